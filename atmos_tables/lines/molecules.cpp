#include "atmos_tables/lines/molecules.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstddef>

#include "atmos_tables/import/text_lines.h"
#include "atmos_tables/lines/spectral_line.h"
#include "host/base/error.h"

namespace raycube::atmos {

namespace {

/// HITRAN's isotopologues of one molecule end well below this.
constexpr int kMostIsotopologues = 99;

struct Vibration {
  double wavenumber_per_cm;
  int degeneracy;
};

struct Molecule {
  std::string name;
  int rotations;  ///< degrees of freedom of rotation: 0, 2, 3
  std::vector<Vibration> vibrations;
};

const std::vector<Molecule>& molecules() {
  static const std::vector<Molecule> list = {
      {"h2o", 3, {{3657, 1}, {1595, 1}, {3756, 1}}},
      {"co2", 2, {{1333, 1}, {667, 2}, {2349, 1}}},
      {"o3", 3, {{1103, 1}, {701, 1}, {1042, 1}}},
      {"n2o", 2, {{2224, 1}, {1285, 1}, {589, 2}}},
      {"co", 2, {{2143, 1}}},
      {"ch4", 3, {{2917, 1}, {1534, 2}, {3019, 3}, {1306, 3}}},
      {"o2", 2, {{1556, 1}}},
      {"no", 2, {{1876, 1}}},
      {"so2", 3, {{1151, 1}, {518, 1}, {1362, 1}}},
      {"no2", 3, {{1318, 1}, {750, 1}, {1618, 1}}},
      {"nh3", 3, {{3337, 1}, {950, 1}, {3444, 2}, {1627, 2}}},
      {"hno3", 3, {{3550, 1}, {1709, 1}, {1331, 1}, {1325, 1}, {879, 1}, {647, 1}, {579, 1}, {762, 1}, {458, 1}}},
      {"oh", 2, {{3570, 1}}},
      {"hf", 2, {{3961, 1}}},
      {"hcl", 2, {{2886, 1}}},
      {"hbr", 2, {{2559, 1}}},
      {"hi", 2, {{2230, 1}}},
      {"clo", 2, {{844, 1}}},
      {"ocs", 2, {{2062, 1}, {859, 1}, {520, 2}}},
      {"h2co", 3, {{2783, 1}, {1746, 1}, {1500, 1}, {1167, 1}, {2843, 1}, {1249, 1}}},
      {"hocl", 3, {{3609, 1}, {1239, 1}, {724, 1}}},
      {"n2", 2, {{2330, 1}}},
      {"hcn", 2, {{3311, 1}, {712, 2}, {2097, 1}}},
      {"ch3cl", 3, {{2937, 1}, {1355, 1}, {732, 1}, {3039, 2}, {1452, 2}, {1017, 2}}},
      {"h2o2", 3, {}},
      {"c2h2", 2, {{3374, 1}, {1974, 1}, {3289, 1}, {612, 2}, {730, 2}}},
      {"c2h6",
       3,
       {{2954, 1},
        {1388, 1},
        {995, 1},
        {289, 1},
        {2896, 1},
        {1379, 1},
        {2969, 2},
        {1468, 2},
        {1190, 2},
        {2985, 2},
        {1469, 2},
        {822, 2}}},
      {"ph3", 3, {{2323, 1}, {992, 1}, {2328, 2}, {1118, 2}}},
      {"cof2", 3, {}},
      {"sf6", 3, {}},
      {"h2s", 3, {{2615, 1}, {1183, 1}, {2626, 1}}},
      {"hcooh", 3, {}},
      {"ho2", 3, {}},
      {"o", 0, {}},
      {"clono2", 3, {}},
      {"no+", 2, {}},
      {"hobr", 3, {}},
      {"c2h4",
       3,
       {{3026, 1},
        {1623, 1},
        {1342, 1},
        {1023, 1},
        {3103, 1},
        {1236, 1},
        {949, 1},
        {943, 1},
        {3106, 1},
        {826, 1},
        {2989, 1},
        {1444, 1}}},
      {"ch3oh", 3, {}},
      {"ch3br", 3, {}},
      {"ch3cn", 3, {}},
      {"cf4", 3, {}},
      {"c4h2", 2, {}},
      {"hc3n", 2, {}},
      {"h2", 2, {}},
      {"cs", 2, {}},
      {"so3", 3, {}},
      {"c2n2", 2, {}},
      {"cocl2", 3, {}},
      {"so", 2, {}},
      {"ch3f", 3, {}},
      {"geh4", 3, {}},
      {"cs2", 2, {}},
      {"ch3i", 3, {}},
      {"nf3", 3, {}},
  };
  return list;
}

const Molecule& find(int molecule) {
  if (molecule < 1 || molecule > molecule_count())
    throw base::Error(base::Fault::bug, "molecule number " + std::to_string(molecule) + " is not in the list of 1 to " +
                                            std::to_string(molecule_count()));
  return molecules()[static_cast<std::size_t>(molecule - 1)];
}

/// Commonest isotopes, g mol-1 (AME2020).
double atom_mass(const std::string& symbol) {
  static const std::array<std::pair<const char*, double>, 12> list = {{{"h", 1.00782503},
                                                                       {"c", 12},
                                                                       {"n", 14.00307400},
                                                                       {"o", 15.99491462},
                                                                       {"f", 18.99840316},
                                                                       {"p", 30.97376200},
                                                                       {"s", 31.97207117},
                                                                       {"cl", 34.96885268},
                                                                       {"br", 78.9183376},
                                                                       {"i", 126.9044719},
                                                                       {"ge", 73.92117776},
                                                                       {"+", 0}}};
  for (const auto& [name, mass] : list)
    if (symbol == name) return mass;
  return 0;
}

double formula_mass(const std::string& formula) {
  double sum = 0;
  for (std::size_t i = 0; i < formula.size();) {
    // Two-letter symbols first: cl, br, ge.
    std::size_t length =
        atom_mass(formula.substr(i, 2)) > 0 && i + 1 < formula.size() && formula.substr(i, 2).size() == 2 ? 2 : 1;
    const double mass = atom_mass(formula.substr(i, length));
    i += length;
    int count = 0;
    while (i < formula.size() && std::isdigit(static_cast<unsigned char>(formula[i])))
      count = 10 * count + (formula[i++] - '0');
    sum += mass * std::max(1, count);
  }
  return sum;
}

/// In HITRAN's order, by abundance on earth.
const std::array<std::vector<double>, 7> kIsotopologueMass_g = {{
    {18.010565, 20.014811, 19.014780, 19.016740, 21.020985, 20.020956, 20.022915},
    {43.989830, 44.993185, 45.994076, 44.994045, 46.997431, 45.997400, 47.998322, 46.998291, 45.994262, 49.001675,
     48.001646, 47.001618},
    {47.984745, 49.988991, 49.988991, 48.988960, 48.988960},
    {44.001062, 44.998096, 44.998096, 46.005308, 45.005278},
    {27.994915, 28.998270, 29.999161, 28.999130, 31.002516, 30.002485},
    {16.031300, 17.034655, 17.037475, 18.040830},
    {31.989830, 33.994076, 32.994045},
}};

/// ln of Q without its constant factor.
double formula_log_q(const Molecule& molecule, double temperature_K) {
  double sum = 0.5 * molecule.rotations * std::log(temperature_K);
  for (const Vibration& v : molecule.vibrations)
    sum -= v.degeneracy * std::log1p(-std::exp(-kC2_cm_K * v.wavenumber_per_cm / temperature_K));
  return sum;
}

}  // namespace

int molecule_count() { return static_cast<int>(molecules().size()); }
const std::string& molecule_name(int molecule) { return find(molecule).name; }

int molecule_number(const std::string& name) {
  for (int i = 1; i <= molecule_count(); ++i)
    if (molecule_name(i) == name) return i;
  return 0;
}

double isotopologue_mass_g(int molecule, int isotopologue) {
  const Molecule& found = find(molecule);
  if (molecule <= static_cast<int>(kIsotopologueMass_g.size())) {
    const auto& masses = kIsotopologueMass_g[static_cast<std::size_t>(molecule - 1)];
    if (isotopologue >= 1 && isotopologue <= static_cast<int>(masses.size()))
      return masses[static_cast<std::size_t>(isotopologue - 1)];
  }
  return formula_mass(found.name);
}

double PartitionSums::ratio(int molecule, int isotopologue, double temperature_K) const {
  for (const Table& table : tables_)
    if (table.molecule == molecule && table.isotopologue == isotopologue)
      return std::exp(log_q(table, kLineReference_K) - log_q(table, temperature_K));
  return std::exp(formula_log_q(find(molecule), kLineReference_K) - formula_log_q(find(molecule), temperature_K));
}

double PartitionSums::log_q(const Table& table, double temperature_K) const {
  const double at = std::log(temperature_K);
  const auto& x = table.log_temperature;
  if (!(at >= x.front() && at <= x.back()))
    throw base::Error(base::Fault::input, file_ + ": partition sum of " + molecule_name(table.molecule) +
                                              " isotopologue " + std::to_string(table.isotopologue) + " ends before " +
                                              std::to_string(temperature_K) +
                                              " K; extend the table to the air's temperatures and 296 K");
  const std::size_t high = std::clamp<std::size_t>(
      static_cast<std::size_t>(std::upper_bound(x.begin(), x.end(), at) - x.begin()), 1, x.size() - 1);
  const double part = (at - x[high - 1]) / (x[high] - x[high - 1]);
  return (1 - part) * table.log_q[high - 1] + part * table.log_q[high];
}

PartitionSums PartitionSums::read_csv(const std::string& file) {
  using namespace imported;
  PartitionSums out;
  out.file_ = file;
  base::Problems problems;
  const CsvTable columns{"partition sums", {"molecule", "isotopologue", "temperature_K", "q"}, "give that header line"};
  read_rows(file, columns, problems, [&](const auto& cells, const base::Where& where, const std::string& line) {
    const Number as_number = read_number(cells[0]);
    const int molecule = as_number.good() ? whole_number(as_number.value, 1, molecule_count()).value_or(0)
                                          : molecule_number(std::string(cells[0]));
    if (molecule < 1 || molecule > molecule_count()) {
      problems.add(where, "unknown molecule", "'" + std::string(cells[0]) + "'",
                   "give HITRAN's number or a formula in lower case");
      return;
    }
    const std::size_t before = problems.count();
    const int isotopologue = need_whole(cells[1], where, "isotopologue", 1, kMostIsotopologues, problems);
    const Number temperature = need_number(cells[2], where, "temperature_K", problems);
    const Number q = need_number(cells[3], where, "q", problems);
    if (problems.count() != before || !temperature.good() || !q.good()) return;
    if (!(temperature.value > 0 && q.value > 0)) {
      problems.add(where, "temperature and q must be above 0", line, "correct the row");
      return;
    }
    auto table = std::find_if(out.tables_.begin(), out.tables_.end(),
                              [&](const Table& t) { return t.molecule == molecule && t.isotopologue == isotopologue; });
    if (table == out.tables_.end())
      table = out.tables_.insert(out.tables_.end(), Table{molecule, isotopologue, {}, {}});
    if (!table->log_temperature.empty() && !(std::log(temperature.value) > table->log_temperature.back()))
      problems.add(where, "temperatures of one isotopologue must ascend", std::string(cells[2]), "sort the rows");
    table->log_temperature.push_back(std::log(temperature.value));
    table->log_q.push_back(std::log(q.value));
  });
  for (const Table& table : out.tables_)
    if (table.log_q.size() < 2)
      problems.add({file, 0, 0, molecule_name(table.molecule)}, "needs at least 2 temperatures", "1", "add rows");
  if (problems.empty() && out.tables_.empty())
    problems.add({file, 0, 0, ""}, "holds no partition sums", "no rows", "add rows");
  problems.throw_if_any();
  return out;
}

}  // namespace raycube::atmos
