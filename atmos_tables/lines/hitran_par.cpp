#include "atmos_tables/lines/hitran_par.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <string_view>

#include "atmos_tables/import/text_lines.h"
#include "atmos_tables/lines/molecules.h"
#include "host/base/error.h"
#include "host/base/input_file.h"

namespace raycube::atmos {

namespace {

using imported::Number;

constexpr std::size_t kRecord = 160;
constexpr std::size_t kChunk = 4u << 20;
constexpr int kMaxLineNumber = 2147483647;

struct Field {
  std::size_t first, count;
  const char* name;
};
constexpr Field kWavenumber{3, 12, "wavenumber"}, kIntensity{15, 10, "intensity"}, kGammaAir{35, 5, "gamma_air"},
    kGammaSelf{40, 5, "gamma_self"}, kEnergy{45, 10, "lower energy"}, kExponent{55, 4, "n_air"},
    kShift{59, 8, "delta_air"};

/// HITRAN's one character: 1-9, then 0, A, B ... 0 when it is none of these.
int isotopologue_of(char c) {
  if (c >= '1' && c <= '9') return c - '0';
  if (c == '0') return 10;
  if (c >= 'A' && c <= 'Z') return 11 + (c - 'A');
  return 0;
}

class Reader {
 public:
  Reader(const std::string& file, double low, double high) : low_(low), high_(high) { out_.file = file; }

  /// Whether to go on.
  bool take(std::string_view record) {
    ++line_;
    if (!record.empty() && record.back() == '\r') record.remove_suffix(1);
    if (record.find_first_not_of(' ') == std::string_view::npos) return true;
    ++out_.records;
    if (record.size() != kRecord) {
      fault("a record has 160 characters", std::to_string(record.size()),
            record.size() == 100 ? "this is the format before 2004; download the list anew in .par format"
                                 : "restore the line, or download the list anew in .par format");
      return go_on();
    }
    int molecule = 0;
    const char* digits = record.data() + (record[0] == ' ' ? 1 : 0);
    const auto read = std::from_chars(digits, record.data() + 2, molecule);
    if (read.ec != std::errc() || read.ptr != record.data() + 2 || molecule < 1 || molecule > molecule_count()) {
      fault("unknown molecule number", "'" + std::string(record.substr(0, 2)) + "'",
            "columns 1-2 hold 1 to " + std::to_string(molecule_count()));
      return go_on();
    }
    double wavenumber = 0;
    if (!quick(record, wavenumber) && !positive(record, kWavenumber, wavenumber)) return go_on();
    auto& extent = extents_[static_cast<std::size_t>(molecule)];
    if (extent.records++ == 0) extent.first_per_cm = extent.last_per_cm = wavenumber;
    extent.first_per_cm = std::min(extent.first_per_cm, wavenumber),
    extent.last_per_cm = std::max(extent.last_per_cm, wavenumber);
    if (wavenumber >= low_ && wavenumber <= high_) add(record, molecule, wavenumber);
    return go_on();
  }

  LineList finish() {
    if (problems_.empty() && out_.records == 0)
      problems_.add({out_.file, 0, 0, ""}, "holds no lines", "an empty file", "give a HITRAN .par file");
    problems_.throw_if_any();
    for (std::size_t m = 1; m < extents_.size(); ++m)
      if (extents_[m].records > 0) out_.molecules[static_cast<int>(m)] = extents_[m];
    std::stable_sort(out_.lines.begin(), out_.lines.end(), [](const SpectralLine& a, const SpectralLine& b) {
      return a.wavenumber_per_cm < b.wavenumber_per_cm;
    });
    return std::move(out_);
  }

 private:
  bool go_on() const { return problems_.count() < imported::kEnoughProblems; }
  void fault(const std::string& what, const std::string& found, const std::string& way_out) {
    problems_.add({out_.file, static_cast<int>(std::min<std::uint64_t>(line_, kMaxLineNumber)), 0, ""}, what, found,
                  way_out);
  }

  /// The usual notation of a wavenumber, without the cost of the rest.
  static bool quick(std::string_view record, double& value) {
    const char *begin = record.data() + kWavenumber.first, *end = begin + kWavenumber.count;
    while (begin < end && *begin == ' ') ++begin;
    const auto read = std::from_chars(begin, end, value, std::chars_format::fixed);
    return read.ec == std::errc() && read.ptr == end && value > 0 &&
           std::memchr(begin, '.', static_cast<std::size_t>(end - begin));
  }

  /// A field that must hold a number with its point: without one Fortran would count digits from the right.
  bool number(std::string_view record, const Field& field, double& value) {
    const std::string_view text = record.substr(field.first, field.count);
    const Number read = imported::read_number(text);
    const std::string columns =
        ", columns " + std::to_string(field.first + 1) + "-" + std::to_string(field.first + field.count);
    if (!read.good()) {
      fault(std::string(field.name) + columns + ", must be a number", "'" + std::string(text) + "'",
            "restore the record");
      return false;
    }
    if (text.find('.') == std::string_view::npos) {
      fault(std::string(field.name) + columns + ", must have a decimal point", "'" + std::string(text) + "'",
            "are the columns shifted? restore the record");
      return false;
    }
    value = read.value;
    return true;
  }
  bool positive(std::string_view record, const Field& field, double& value) {
    if (!number(record, field, value)) return false;
    if (value > 0) return true;
    fault(std::string(field.name) + " must be above 0",
          "'" + std::string(record.substr(field.first, field.count)) + "'", "correct or remove the record");
    return false;
  }

  void add(std::string_view record, int molecule, double wavenumber) {
    SpectralLine line;
    line.molecule = molecule;
    line.isotopologue = isotopologue_of(record[2]);
    line.wavenumber_per_cm = wavenumber;
    bool good = true;
    if (line.isotopologue == 0) {
      fault("unknown isotopologue", "'" + std::string(record.substr(2, 1)) + "'",
            "column 3 holds 1-9, 0 or a capital letter");
      good = false;
    }
    good = positive(record, kIntensity, line.intensity) && good;
    good = positive(record, kGammaAir, line.gamma_air) && good;
    const std::string_view self = record.substr(kGammaSelf.first, kGammaSelf.count);
    line.gamma_self = line.gamma_air;
    if (self.find_first_not_of(' ') != std::string_view::npos)
      good = number(record, kGammaSelf, line.gamma_self) && good;
    if (line.gamma_self < 0) {
      fault("gamma_self must not be negative", "'" + std::string(self) + "'", "correct or blank the field");
      good = false;
    }
    if (line.gamma_self == 0) line.gamma_self = line.gamma_air;
    good = number(record, kEnergy, line.lower_energy_per_cm) && good;
    good = number(record, kExponent, line.n_air) && good;
    good = number(record, kShift, line.delta_air) && good;
    if (!good) return;
    if (line.lower_energy_per_cm < 0) ++out_.unknown_energy, line.lower_energy_per_cm = -1;
    out_.lines.push_back(line);
  }

  LineList out_;
  base::Problems problems_;
  double low_, high_;
  std::uint64_t line_ = 0;
  std::array<LineList::Extent, 100> extents_{};
};

}  // namespace

LineList read_hitran_par(const std::string& file, double low_per_cm, double high_per_cm) {
  base::refuse_other_than_plain(file);
  std::ifstream in(file, std::ios::binary);
  if (!in) throw base::Error(base::Fault::environment, file + ": cannot be read; check the name and its permissions");
  Reader reader(file, low_per_cm, high_per_cm);
  std::vector<char> buffer(kChunk);
  std::size_t kept = 0;
  for (bool going = true; going;) {
    in.read(buffer.data() + kept, static_cast<std::streamsize>(buffer.size() - kept));
    const std::size_t filled = kept + static_cast<std::size_t>(in.gcount());
    if (in.bad()) throw base::Error(base::Fault::environment, file + ": reading failed; is it a file on a sound disk?");
    const bool last = filled < buffer.size();
    std::size_t begin = 0;
    while (going) {
      const void* end = std::memchr(buffer.data() + begin, '\n', filled - begin);
      if (!end) break;
      const std::size_t stop = static_cast<std::size_t>(static_cast<const char*>(end) - buffer.data());
      going = reader.take({buffer.data() + begin, stop - begin});
      begin = stop + 1;
    }
    kept = filled - begin;
    // No line end in 4 MB, or the rest of the file: one last record.
    if (going && (last || begin == 0) && kept > 0) {
      reader.take({buffer.data() + begin, kept});
      break;
    }
    if (last) break;
    std::memmove(buffer.data(), buffer.data() + begin, kept);
  }
  return reader.finish();
}

}  // namespace raycube::atmos
