#include "host/base/options.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/memory.h"

namespace raycube::base {
namespace {

Error refuse(const std::string& name, const std::string& rule, const std::string& found) {
  return Error(Fault::input, name + " must be " + rule + " (found \"" + found + "\"); see --help");
}

template <class Number>
std::string range_text(Number low, Number high) {
  const bool open_low = low == std::numeric_limits<Number>::lowest(),
             open_high = high == std::numeric_limits<Number>::max();
  if (open_low && open_high) return "";
  if (open_high) return fmt::format("at least {}", low);
  if (open_low) return fmt::format("at most {}", high);
  return fmt::format("{} to {}", low, high);
}

template <class Number>
Number parse_in_range(const std::string& name, const char* kind, const std::string& text, Number low, Number high) {
  Number value{};
  const auto [rest, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc() || rest != text.data() + text.size()) throw refuse(name, kind, text);
  if constexpr (std::is_floating_point_v<Number>)
    if (!std::isfinite(value)) throw refuse(name, "a finite number", text);
  if (value < low || value > high) throw refuse(name, range_text(low, high), text);
  return value;
}

template <class Integer>
Option integer_row(const std::string& names, const std::string& unit, Integer low, Integer high,
                   const std::string& help, std::function<void(Integer)> store) {
  Option row;
  row.names = names;
  row.type = "integer";
  row.value_name = "N";
  row.unit = unit;
  row.range = range_text(low, high);
  row.help = help;
  row.set = [name = row.long_name(), low, high, store](const std::string& typed) {
    store(parse_in_range(name, "a whole number", typed, low, high));
  };
  return row;
}

}  // namespace

std::string Option::long_name() const { return names.substr(names.rfind(',') + 1); }

Option& OptionTable::add(Option option) {
  for (const auto& row : rows_)
    if (row.long_name() == option.long_name()) throw Error(Fault::bug, "option declared twice: " + option.names);
  rows_.push_back(std::move(option));
  return rows_.back();
}

Option& OptionTable::flag(const std::string& names, const std::string& help, bool& value) {
  Option row;
  row.names = names, row.type = "flag", row.help = help;
  row.set = [&value](const std::string&) { value = true; };
  return add(row);
}

Option& OptionTable::count(const std::string& names, const std::string& help, int& value) {
  Option row;
  row.names = names, row.type = "count", row.help = help, row.repeats = true;
  row.set = [&value](const std::string&) { ++value; };
  return add(row);
}

Option& OptionTable::text(const std::string& names, const std::string& value_name, const std::string& help,
                          std::string& value) {
  Option row;
  row.names = names, row.type = "text", row.value_name = value_name, row.help = help, row.default_text = value;
  row.set = [&value, name = row.long_name()](const std::string& typed) {
    if (typed.empty()) throw refuse(name, "not empty", typed);
    value = typed;
  };
  return add(row);
}

Option& OptionTable::texts(const std::string& names, const std::string& value_name, const std::string& help,
                           std::vector<std::string>& values) {
  Option row;
  row.names = names, row.type = "text", row.value_name = value_name, row.help = help, row.repeats = true;
  row.set = [&values, name = row.long_name()](const std::string& typed) {
    if (typed.empty()) throw refuse(name, "not empty", typed);
    values.push_back(typed);
  };
  return add(row);
}

Option& OptionTable::choice(const std::string& names, const std::vector<std::string>& choices, const std::string& help,
                            std::string& value) {
  Option row;
  row.names = names, row.type = "choice", row.value_name = "NAME", row.help = help, row.default_text = value;
  row.range = fmt::format("{}", fmt::join(choices, ", "));
  row.set = [&value, choices, name = row.long_name(), range = row.range](const std::string& typed) {
    if (std::find(choices.begin(), choices.end(), typed) == choices.end()) throw refuse(name, "one of " + range, typed);
    value = typed;
  };
  return add(row);
}

Option& OptionTable::number(const std::string& names, const std::string& unit, double low, double high,
                            const std::string& help, double& value) {
  Option row;
  row.names = names, row.type = "number", row.value_name = "X", row.unit = unit, row.help = help;
  row.default_text = fmt::format("{}", value);
  row.range = range_text(low, high);
  row.set = [&value, low, high, name = row.long_name()](const std::string& typed) {
    value = parse_in_range(name, "a number", typed, low, high);
  };
  return add(row);
}

Option& OptionTable::memory(const std::string& names, const std::string& help, std::uint64_t& bytes) {
  Option row;
  row.names = names, row.type = "memory", row.value_name = "SIZE", row.help = help;
  row.unit = "bytes, or with K, M, G, T";
  row.default_text = format_bytes(bytes);
  row.set = [&bytes, name = row.long_name()](const std::string& typed) {
    try {
      bytes = parse_memory_size(typed);
    } catch (const Error& error) {
      throw Error(error.fault(), name + ": " + error.what());
    }
  };
  return add(row);
}

template <class Integer>
Option& OptionTable::integer(const std::string& names, const std::string& unit, Integer low, Integer high,
                             const std::string& help, Integer& value) {
  Option row = integer_row<Integer>(names, unit, low, high, help, [&value](Integer typed) { value = typed; });
  row.default_text = fmt::format("{}", value);
  return add(row);
}

template <class Integer>
Option& OptionTable::integer(const std::string& names, const std::string& unit, Integer low, Integer high,
                             const std::string& help, std::optional<Integer>& value) {
  return add(integer_row<Integer>(names, unit, low, high, help, [&value](Integer typed) { value = typed; }));
}

#define RAYCUBE_INTEGER_OPTION(T)                                                                              \
  template Option& OptionTable::integer(const std::string&, const std::string&, T, T, const std::string&, T&); \
  template Option& OptionTable::integer(const std::string&, const std::string&, T, T, const std::string&,      \
                                        std::optional<T>&);
RAYCUBE_INTEGER_OPTION(int)
RAYCUBE_INTEGER_OPTION(std::uint32_t)
RAYCUBE_INTEGER_OPTION(std::int64_t)
RAYCUBE_INTEGER_OPTION(std::uint64_t)

Option& OptionTable::argument(const std::string& placeholder, const std::string& help, std::string& value) {
  Option& row = text(placeholder, placeholder, help, value);
  row.positional = row.required = true;
  return row;
}

Option& OptionTable::optional_argument(const std::string& placeholder, const std::string& help, std::string& value) {
  Option& row = text(placeholder, placeholder, help, value);
  row.positional = true;
  return row;
}

Option& OptionTable::arguments(const std::string& placeholder, const std::string& help,
                               std::vector<std::string>& values) {
  Option& row = texts(placeholder, placeholder, help, values);
  row.positional = row.required = true;
  return row;
}

}  // namespace raycube::base
