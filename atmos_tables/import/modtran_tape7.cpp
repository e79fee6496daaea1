#include "atmos_tables/import/modtran_tape7.h"

#include <algorithm>
#include <cctype>
#include <cstring>
#include <sstream>

#include "atmos_tables/import/modtran_cards.h"
#include "atmos_tables/import/modtran_names.h"
#include "atmos_tables/import/text_lines.h"

namespace raycube::atmos::imported {

namespace {

struct Field {
  std::string label;
  std::size_t end;  ///< column after the label's last character
};

/// MODTRAN 4 writes its labels with a blank where later versions write an underscore; the width is the same.
std::string joined_labels(std::string header) {
  for (const char* label :
       {"TOT TRANS", "PTH THRML", "THRML SCT", "THRML EM", "SURF EMIS", "SOL SCAT", "SING SCAT", "MULT SCAT",
        "GRND RFLT", "DRCT RFLT", "TOTAL RAD", "REF SOL", "SOL TR", "DIR EM", "TOA SUN"})
    for (std::size_t at = header.find(label); at != std::string::npos; at = header.find(label, at + 1))
      header[header.find(' ', at)] = '_';
  return header;
}

std::vector<Field> fields_of(const std::string& header) {
  std::vector<Field> out;
  for (const auto& token : split_blanks(header))
    out.push_back({std::string(token), static_cast<std::size_t>(token.data() - header.data()) + token.size()});
  return out;
}

bool is_header(const std::string& line) {
  const auto tokens = split_blanks(line);
  return tokens.size() > 2 &&
         (tokens[0].rfind("FREQ", 0) == 0 || tokens[0].rfind("WAVEL", 0) == 0 || tokens[0].rfind("WAVLEN", 0) == 0);
}

bool is_end_mark(const std::string& line) {
  const auto tokens = split_blanks(line);
  return tokens.size() == 1 && tokens[0].rfind("-9999", 0) == 0;
}

bool has_no_number(const std::string& line) {
  const auto tokens = split_blanks(line);
  const char first = tokens.empty() ? '\0' : tokens[0][0];
  return !tokens.empty() && !std::isdigit(static_cast<unsigned char>(first)) && !std::strchr("+-.*", first);
}

enum class Layout { transmittance, radiance, irradiance };

/// One run of the file while its rows are read.
class RunReader {
 public:
  RunReader(const std::string& file, base::Problems& problems) : file_(file), problems_(problems) {}

  /// Reads header and data from line `at` (index) on; returns the index after the end mark.
  std::size_t read(const std::vector<std::string>& lines, std::size_t at, const ModtranCards& cards,
                   std::vector<Run>& runs) {
    header_line_ = static_cast<int>(at) + 1;
    cards_ = &cards;
    const std::string header = joined_labels(lines[at]);
    std::string second;
    if (++at < lines.size() && has_no_number(lines[at])) second = lines[at++];
    if (!choose_layout(header, second)) return lines.size();
    std::size_t end = at;
    while (end < lines.size() && !is_end_mark(lines[end]) && !is_header(lines[end])) ++end;
    if (end == lines.size() || !is_end_mark(lines[end]))
      problems_.add(where(end), "the run ends without the mark -9999", "", "the file is cut short; run the code anew");
    for (std::size_t i = at; i < end && problems_.count() < kEnoughProblems; ++i)
      row(lines[i], static_cast<int>(i) + 1);
    finish(second, runs);
    return end + 1;
  }

 private:
  base::Where where(std::size_t line) const { return {file_, static_cast<int>(line), 0, ""}; }
  base::Where here(int line) const { return {file_, line, 0, ""}; }

  bool choose_layout(const std::string& header, const std::string& second) {
    const auto labels = fields_of(header);
    const auto holds = [&](const char* word) {
      return std::any_of(labels.begin(), labels.end(), [&](const Field& f) { return f.label.rfind(word, 0) == 0; });
    };
    axis_label_ = labels.front().label;
    if (holds("COMBIN")) {
      layout_ = Layout::transmittance;
      // Labels of the first line may touch ("H2-CH4CH4-CH4"); those of the second do not, and end where the first
      // line's do.
      std::size_t from = 0;
      for (const Field& f : fields_of(second)) {
        fields_.push_back({std::string(trimmed(card_field(header, from, f.end - from))), f.end});
        seconds_.push_back(f.label);
        from = f.end;
      }
      if (fields_.size() < 2) {
        problems_.add(here(header_line_), "the second header line of transmittances is missing", "",
                      "is the file whole?");
        return false;
      }
    } else if (holds("TOTAL_RAD")) {
      layout_ = Layout::radiance;
      fields_ = labels;
    } else if (holds("SOL_TR")) {
      layout_ = Layout::irradiance;
      fields_ = labels;
      fields_.push_back({"DEPTH", 0});
    } else {
      problems_.add(here(header_line_), "the header names none of COMBIN, TOTAL_RAD and SOL TR",
                    std::string(trimmed(header)).substr(0, 60), "is it a tape7 file?");
      return false;
    }
    const int expected = layout_ == Layout::transmittance ? 0 : layout_ == Layout::irradiance ? 3 : 1;
    if (cards_->iemsct && (*cards_->iemsct == 0 || *cards_->iemsct == 3 ? *cards_->iemsct : 1) != expected)
      problems_.add(here(header_line_), "the header is not that of the run on card 1",
                    "IEMSCT " + std::to_string(*cards_->iemsct), "header and cards are of two runs");
    numbers_.resize(fields_.size());
    return true;
  }

  void row(const std::string& line, int number) {
    std::vector<std::string_view> values;
    if (layout_ == Layout::radiance) {
      if (!cut(line, number, values)) return;
    } else {
      values = split_blanks(line);
      if (values.size() != fields_.size()) {
        const bool stars = line.find("**") != std::string::npos;
        problems_.add(here(number),
                      stars ? "a value did not fit its field" : "the row has another number of fields than the header",
                      stars ? "****" : std::to_string(values.size()) + " of " + std::to_string(fields_.size()),
                      "the row is damaged or cut short");
        return;
      }
    }
    for (std::size_t i = 0; i < fields_.size(); ++i) {
      Number value;
      if (layout_ == Layout::radiance && trimmed(values[i]).empty() && i > 0) {
        if (!lines_.empty() && numbers_[i].front().good())
          problems_.add(here(number), fields_[i].label + " is blank here and not in the rows above", "",
                        "the row is damaged or cut short");
      } else {
        value = need_number(values[i], here(number), fields_[i].label, problems_);
        if (!lines_.empty() && !numbers_[i].front().good() && value.good())
          problems_.add(here(number), fields_[i].label + " has a value here and is blank in the rows above",
                        std::string(trimmed(values[i])), "the row is damaged");
      }
      numbers_[i].push_back(value);
    }
    lines_.push_back(number);
    check_order(number);
  }

  /// Cuts a row at the ends of the labels. Every number must end where its label ends.
  bool cut(const std::string& line, int number, std::vector<std::string_view>& values) {
    std::size_t from = 0;
    for (const Field& field : fields_) {
      const std::string_view text = card_field(line, from, field.end - from);
      if (!trimmed(text).empty() && (text.size() < field.end - from || text.back() == ' ')) {
        problems_.add(here(number), "the number under " + field.label + " does not end where its label ends",
                      std::string(trimmed(text)), "the columns have moved or the row is cut short");
        return false;
      }
      values.push_back(text);
      from = field.end;
    }
    if (from < line.size() && !trimmed(std::string_view(line).substr(from)).empty()) {
      problems_.add(here(number), "the row is longer than its header",
                    std::string(trimmed(std::string_view(line).substr(from))), "the columns have moved");
      return false;
    }
    return true;
  }

  void check_order(int number) {
    const auto& axis = numbers_.front();
    const std::size_t n = axis.size();
    if (!axis.back().good() || axis.back().value <= 0) {
      if (axis.back().good())
        problems_.add(here(number), axis_label_ + " is not above 0", std::to_string(axis.back().value), "");
      return;
    }
    if (n < 2) return;
    const double step = axis[n - 1].value - axis[n - 2].value, first = axis[1].value - axis[0].value;
    if (step == 0 || (step > 0) != (first > 0))
      problems_.add(here(number), axis_label_ + " does not keep its order",
                    std::to_string(axis[n - 1].value) + " after " + std::to_string(axis[n - 2].value),
                    "rows are out of order or doubled");
  }

  void finish(const std::string& second, std::vector<Run>& runs) {
    if (lines_.empty()) {
      problems_.add(here(header_line_), "no data rows below the header", "", "the file is cut short");
      return;
    }
    if (!problems_.empty()) return;
    const std::string unit_line = seconds_.empty() ? std::string(trimmed(second)) : seconds_.front();
    const std::string label =
        unit_line.empty() ? axis_label_ : axis_label_ + " " + std::string(split_blanks(unit_line).front());
    const auto& axis = numbers_.front();
    const auto unit =
        settle_axis(label, axis.front().value, axis.back().value, cards_->band, here(header_line_), problems_);
    if (!unit) return;
    Run run;
    run.mode = layout_ == Layout::transmittance ? "transmittance"
               : layout_ == Layout::radiance    ? "radiance"
                                                : "direct irradiance";
    run.geometry = cards_->geometry;
    note_band(run, *unit);
    for (const Number& number : axis) run.wavelength_um.push_back(wavelength_um_from_axis(number.value, *unit));
    for (std::size_t i = 1; i < fields_.size(); ++i) {
      if (!numbers_[i].front().good()) continue;  // not computed: absent by name
      const std::string second_label = seconds_.empty() ? "" : seconds_[i];
      const std::string source = fields_[i].label + (second_label.empty() ? "" : " " + second_label);
      const auto quantity = modtran_quantity(fields_[i].label, second_label);
      if (!quantity) {
        run.notes.push_back("column " + source + " is not known and was left out");
        continue;
      }
      Column column = modtran_column(*quantity, source);
      for (std::size_t k = 0; k < axis.size(); ++k)
        append_modtran(column, quantity->kind, numbers_[i][k], *unit, run.wavelength_um[k]);
      run.columns.push_back(std::move(column));
    }
    if (layout_ == Layout::radiance) {
      if (!run.find("radiance"))
        problems_.add(here(header_line_), "TOTAL_RAD is blank", "", "the rows are cut short");
      else
        settle_radiance(run, here(header_line_), lines_, problems_);
    }
    sort_ascending(run);
    check_run(run, here(header_line_), problems_);
    runs.push_back(std::move(run));
  }

  /// A file cut down to a part of its band (5 % of it missing at an end) is read, with a word on what is missing.
  void note_band(Run& run, AxisUnit unit) const {
    const auto& band = cards_->band;
    if (!band || band->unit != unit) return;
    const auto [low, high] = std::minmax(numbers_.front().front().value, numbers_.front().back().value);
    const double allowed = band->slack + 0.05 * (band->last - band->first);
    if (low <= band->first + allowed && high >= band->last - allowed) return;
    std::ostringstream text;
    text << "the run was asked for " << band->first << " to " << band->last << " " << axis_unit_name(unit)
         << ", the file holds " << low << " to " << high;
    run.notes.push_back(text.str());
  }

  std::string file_;
  base::Problems& problems_;
  const ModtranCards* cards_ = nullptr;
  int header_line_ = 0;
  Layout layout_ = Layout::radiance;
  std::string axis_label_;
  std::vector<Field> fields_;
  std::vector<std::string> seconds_;
  std::vector<std::vector<Number>> numbers_;  ///< per field, per row; blank where not computed
  std::vector<int> lines_;
};

}  // namespace

Imported read_tape7(const std::string& path, const std::string& format) {
  const auto lines = read_lines(path);
  Imported out{path, "MODTRAN", format, {}};
  base::Problems problems;
  std::vector<std::string> echo;
  for (std::size_t i = 0; i < lines.size() && problems.count() < kEnoughProblems;) {
    if (!is_header(lines[i])) {
      if (!trimmed(lines[i]).empty()) echo.push_back(lines[i]);
      ++i;
      continue;
    }
    const ModtranCards cards = read_modtran_cards(echo);
    i = RunReader(path, problems).read(lines, i, cards, out.runs);
    echo.clear();
  }
  if (out.runs.empty() && problems.empty())
    problems.add({path, 0, 0, ""}, "no header line that starts with FREQ", "", "is it a tape7 file?");
  problems.throw_if_any();
  return out;
}

}  // namespace raycube::atmos::imported
