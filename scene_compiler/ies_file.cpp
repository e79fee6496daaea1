#include "scene_compiler/ies_file.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "host/base/text.h"
#include "scene_compiler/csv_file.h"
#include "scene_compiler/document_values.h"

namespace raycube::scene {

namespace {

using base::Problems;

constexpr int kTypeC = 1;
constexpr double kMostAngles = 1000;

/// The numbers after the line TILT=, with what follows an included tilt table taken out.
class Numbers {
 public:
  Numbers(std::string text, const std::string& file, Problems& problems) : file_(file), problems_(problems) {
    std::replace(text.begin(), text.end(), ',', ' ');
    stream_.str(base::without_dos_end(std::move(text)));
  }
  double next(const char* what) {
    std::string word;
    if (!sound_ || !(stream_ >> word)) {
      fail(std::string("the file ends before ") + what, "");
      return 0;
    }
    const auto number = parse_number(word);
    if (!number || !std::isfinite(*number)) fail(std::string("a number is due: ") + what, "'" + word + "'");
    return sound_ ? *number : 0;
  }
  std::size_t count(const char* what) {
    const double number = next(what);
    if (sound_ && !(number >= 1 && number <= kMostAngles && number == std::floor(number)))
      fail(std::string(what) + " must be a count", number_text(number));
    return sound_ ? static_cast<std::size_t>(number) : 0;
  }
  std::vector<double> list(std::size_t count, const char* what) {
    std::vector<double> out;
    for (std::size_t i = 0; i < count && sound_; ++i) out.push_back(next(what));
    return out;
  }
  void fail(const std::string& what, const std::string& found) {
    if (sound_) problems_.add({file_, 0, 0, ""}, what, found, "give a file of IES LM-63, type C");
    sound_ = false;
  }
  /// Nothing may stand behind the last number.
  void end() {
    if (std::string word; sound_ && stream_ >> word) fail("more numbers than the file counts", word);
  }
  void tell(const char* what) { problems_.tell({file_, 0, 0, ""}, what); }
  bool sound() const { return sound_; }

 private:
  std::istringstream stream_;
  const std::string& file_;
  Problems& problems_;
  bool sound_ = true;
};

bool ascends(const std::vector<double>& values) {
  return std::adjacent_find(values.begin(), values.end(), std::greater_equal<>()) == values.end();
}

/// Planes that symmetry leaves out, so that they go from 0 to 360 deg.
void unfold(LampDistribution& out, Numbers& numbers) {
  std::vector<double>& angle = out.horizontal_deg;
  const std::size_t rows = out.vertical_deg.size();
  const double first = angle.front(), last = angle.back();
  if (angle.size() == 1) {
    angle = {0};
    return;
  }
  struct Plane {
    double deg;
    std::size_t of;
  };
  std::vector<Plane> planes;
  for (std::size_t i = 0; i < angle.size(); ++i) planes.push_back({angle[i], i});
  const auto mirror = [&](double about) {  // what lies at a also lies at 2 about - a
    for (std::size_t i = planes.size(); i-- > 0;)
      if (planes[i].deg != about) planes.push_back({2 * about - planes[i].deg, planes[i].of});
  };
  if (first == 0 && last == 90) {
    mirror(90), mirror(180);
  } else if (first == 0 && last == 180) {
    mirror(180);
  } else if (first == 90 && last == 270) {
    for (std::size_t i = 0; i < angle.size(); ++i) planes.push_back({540 - angle[i], i});
    for (Plane& plane : planes)
      if (plane.deg >= 360) plane.deg -= 360;
    const auto north = std::find_if(planes.begin(), planes.end(), [](const Plane& p) { return p.deg == 0; });
    if (north != planes.end()) planes.push_back({360, north->of});
  } else if (first != 0 || last != 360) {
    numbers.fail("horizontal angles must go from 0 to 0, 90, 180 or 360 deg, or from 90 to 270",
                 number_text(first) + " to " + number_text(last));
    return;
  }
  std::sort(planes.begin(), planes.end(), [](const Plane& a, const Plane& b) { return a.deg < b.deg; });
  planes.erase(std::unique(planes.begin(), planes.end(), [](const Plane& a, const Plane& b) { return a.deg == b.deg; }),
               planes.end());
  if (planes.front().deg != 0 || planes.back().deg != 360) {
    numbers.fail("horizontal angles from 90 to 270 deg need the plane of 180", "none");
    return;
  }
  std::vector<double> angles, values;
  for (const Plane& plane : planes) {
    angles.push_back(plane.deg);
    const auto from = out.value.begin() + static_cast<std::ptrdiff_t>(plane.of * rows);
    values.insert(values.end(), from, from + static_cast<std::ptrdiff_t>(rows));
  }
  angle = std::move(angles), out.value = std::move(values);
}

/// What follows the line TILT=.
/// 2019: LM-63-2019, whose file type stands where older files have the ballast-lamp factor.
LampDistribution read_numbers(Numbers& numbers, bool tilt_included, bool of_2019) {
  LampDistribution out;
  if (tilt_included) {
    numbers.next("the tilt's geometry");
    const std::size_t pairs = numbers.count("the number of tilt angles");
    const std::vector<double> tilt = numbers.list(2 * pairs, "tilt angles and factors");
    if (std::any_of(tilt.begin() + static_cast<std::ptrdiff_t>(tilt.size() / 2), tilt.end(),
                    [](double factor) { return factor != 1; }))
      numbers.tell("its factors for tilted lamps are not used");
  }
  numbers.list(2, "the number of lamps and their lumens");
  const double multiplier = numbers.next("the candela multiplier");
  const std::size_t rows = numbers.count("the number of vertical angles");
  const std::size_t columns = numbers.count("the number of horizontal angles");
  const double type = numbers.next("the photometric type");
  if (numbers.sound() && type != kTypeC) numbers.fail("the photometric type must be C (1)", number_text(type));
  numbers.list(4, "units and size of the luminous opening");
  const double ballast = numbers.next("the ballast factor"),
               ballast_lamp = numbers.next("the ballast-lamp factor or the file's type");
  numbers.next("the input watts");
  out.vertical_deg = numbers.list(rows, "vertical angles");
  out.horizontal_deg = numbers.list(columns, "horizontal angles");
  out.value = numbers.list(rows * columns, "candelas");
  numbers.end();
  if (!numbers.sound()) return out;
  if (!ascends(out.vertical_deg) || out.vertical_deg.front() < 0 || out.vertical_deg.back() > 180 || rows < 2)
    numbers.fail("vertical angles must ascend within 0 to 180 deg",
                 number_text(out.vertical_deg.front()) + " to " + number_text(out.vertical_deg.back()));
  else if (!ascends(out.horizontal_deg))
    numbers.fail("horizontal angles must ascend", "");
  else if (*std::min_element(out.value.begin(), out.value.end()) < 0)
    numbers.fail("candelas must not be negative", number_text(*std::min_element(out.value.begin(), out.value.end())));
  if (!numbers.sound()) return out;
  unfold(out, numbers);
  const double largest = *std::max_element(out.value.begin(), out.value.end());
  out.largest_cd = largest * multiplier * ballast * (of_2019 ? 1 : ballast_lamp);
  if (numbers.sound() && !(out.largest_cd > 0))
    numbers.fail("the luminaire sends no light", number_text(out.largest_cd) + " cd at most");
  if (!numbers.sound()) return out;
  for (double& value : out.value) value /= largest;
  return out;
}

}  // namespace

std::optional<LampDistribution> read_ies(const std::string& file, const base::Where& asked_by, Problems& problems) {
  const auto text = read_whole_file(file, asked_by, problems);
  if (!text) return std::nullopt;
  std::istringstream lines(*text);
  std::string line;
  bool found = false, included = false;
  while (!found && std::getline(lines, line)) {
    const std::string key = trimmed(line);
    if (lower_case(key).rfind("tilt=", 0) != 0) continue;
    found = true;
    const std::string tilt = lower_case(trimmed(key.substr(5)));
    included = tilt == "include";
    if (tilt != "none" && !included) {
      problems.add({file, 0, 0, ""}, "TILT= names another file", "'" + tilt + "'", "include the tilt, or give NONE");
      return std::nullopt;
    }
  }
  if (!found) {
    problems.add({file, 0, 0, ""}, "no line TILT=", "", "give a file of IES LM-63, type C");
    return std::nullopt;
  }
  std::ostringstream rest;
  rest << lines.rdbuf();
  Numbers numbers(rest.str(), file, problems);
  LampDistribution out = read_numbers(numbers, included, text->find("LM-63-2019") < text->find("TILT="));
  return numbers.sound() ? std::optional(std::move(out)) : std::nullopt;
}

}  // namespace raycube::scene
