#include "scene_compiler/measure_builder.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "scene_compiler/document_values.h"

namespace raycube::scene {
namespace {

using base::Problems;

constexpr double kMostViews = 10000;

Measure read_measure(const Record& record, const std::vector<Record>& instruments, Problems& problems) {
  Measure out;
  out.name = record.text("name");
  out.bands_of = banded_instrument(record, instruments, problems);
  std::copy_n(record.numbers("center_m").begin(), 2, out.center_m.begin());
  std::copy_n(record.numbers("size_m").begin(), 2, out.size_m.begin());
  if (record.given("height_m")) out.height_m = record.number("height_m");
  const std::string& views = record.text("views");
  out.views = views == "principal"    ? MeasureViews::principal
              : views == "orthogonal" ? MeasureViews::orthogonal
                                      : MeasureViews::hemisphere;
  const auto& zenith_deg = record.numbers("zenith_deg");
  out.first_deg = zenith_deg[0], out.last_deg = zenith_deg[1], out.step_deg = zenith_deg[2];
  if (!(out.step_deg > 0 && out.last_deg >= out.first_deg))
    problems.add(record.place("zenith_deg"), "zenith angles go up from the first to the last by a step above 0",
                 number_text(out.first_deg) + ", " + number_text(out.last_deg) + ", " + number_text(out.step_deg),
                 "write zenith_deg = [-75, 75, 2]");
  else if (const double count = (out.last_deg - out.first_deg) / out.step_deg + 1; count > kMostViews)
    problems.add(record.place("zenith_deg"), "more than 10000 views of one measure", number_text(std::floor(count)),
                 "give a larger step");
  const char* const other = out.views == MeasureViews::hemisphere ? "zenith_deg" : "directions";
  if (record.given(other))
    problems.add(record.place(other), std::string("'") + other + "' means nothing for views = \"" + views + "\"", "",
                 "remove it");
  out.directions = static_cast<int>(record.integer("directions"));
  out.pixels = static_cast<int>(record.integer("pixels"));
  out.samples = static_cast<int>(record.integer("samples"));
  out.paths = static_cast<int>(record.integer("paths"));
  return out;
}

}  // namespace

std::string banded_instrument(const Record& record, const std::vector<Record>& instruments, base::Problems& problems) {
  std::string known;
  for (const Record& instrument : instruments) known += (known.empty() ? "" : ", ") + instrument.text("name");
  if (record.given("bands_of")) {
    const std::string& name = record.text("bands_of");
    if (std::any_of(instruments.begin(), instruments.end(),
                    [&](const Record& instrument) { return instrument.text("name") == name; }))
      return name;
    problems.add(record.place("bands_of"), "no instrument of that name", "'" + name + "'",
                 known.empty() ? "add an [[instrument]] with the bands" : "the file has: " + known);
    return "";
  }
  if (instruments.size() == 1) return instruments[0].text("name");
  problems.add(record.where, "it has the bands of an instrument",
               instruments.empty() ? "the file has none" : "the file has " + known,
               instruments.empty() ? "add an [[instrument]] with the bands" : "name one in bands_of");
  return "";
}

std::vector<Measure> read_measures(const Record& root, Problems& problems) {
  std::vector<Measure> out;
  std::map<std::string, base::Where> places;
  for (const auto& record : root.records("measure")) {
    const std::string& name = record.text("name");
    check_folder_name(record, "a measure", problems);
    if (const auto [place, fresh] = places.emplace(name, record.where); !fresh)
      problems.add(record.where, "measure '" + name + "' is defined twice", "first in " + place->second.text(),
                   "rename one");
    if (record.sound) out.push_back(read_measure(record, root.records("instrument"), problems));
  }
  return out;
}

}  // namespace raycube::scene
