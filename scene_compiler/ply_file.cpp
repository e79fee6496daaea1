#include "scene_compiler/ply_file.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <sstream>
#include <string_view>

#include "host/base/text.h"
#include "scene_compiler/csv_file.h"
#include "scene_compiler/document_values.h"

namespace raycube::scene {
namespace {

using base::Problems;

constexpr std::size_t kLongestLine = 65536;

enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

/// Of a type's name: Turk's, and those with sizes that came later.
std::optional<Type> type_named(const std::string& name) {
  static const std::map<std::string, Type> known = {
      {"char", Type::int8},   {"uchar", Type::uint8},   {"short", Type::int16},     {"ushort", Type::uint16},
      {"int", Type::int32},   {"uint", Type::uint32},   {"float", Type::float32},   {"double", Type::float64},
      {"int8", Type::int8},   {"uint8", Type::uint8},   {"int16", Type::int16},     {"uint16", Type::uint16},
      {"int32", Type::int32}, {"uint32", Type::uint32}, {"float32", Type::float32}, {"float64", Type::float64}};
  const auto found = known.find(name);
  return found == known.end() ? std::nullopt : std::optional(found->second);
}

std::size_t bytes_of(Type type) {
  switch (type) {
    case Type::int8:
    case Type::uint8:
      return 1;
    case Type::int16:
    case Type::uint16:
      return 2;
    case Type::float64:
      return 8;
    default:
      return 4;
  }
}

struct Property {
  std::string name;
  std::optional<Type> count;  ///< of a list: the type of its length
  Type type = Type::float32;
};

struct Element {
  int line = 0;
  std::string name, digits;
  double count = 0;
  std::vector<Property> properties;

  /// Place of the first property of one of these names; none: -1.
  int find(std::initializer_list<const char*> names) const {
    for (const char* wanted : names)
      for (std::size_t i = 0; i < properties.size(); ++i)
        if (properties[i].name == wanted) return static_cast<int>(i);
    return -1;
  }
};

enum class Form { text, little_endian, big_endian };

/// A problem, of which the first ends the reading.
struct Unsound {
  int line;
  std::string element, what, found, way_out;
};

class Header {
 public:
  explicit Header(const std::string& text) : text_(text) {}

  void read() {
    bool formatted = false;
    while (const auto line = next_line()) {
      std::istringstream stream{std::string(*line)};
      std::vector<std::string> words;
      for (std::string word; stream >> word;) words.push_back(word);
      if (words.empty() || words[0] == "ply" || words[0] == "comment" || words[0] == "obj_info") continue;
      if (words[0] == "end_header") {
        data = at_;
        if (!formatted)
          throw Unsound{line_number, "", "PLY header names no format", "end_header",
                        "add format ascii 1.0, or what it is"};
        check_counts();
        return;
      }
      const bool is_format = words[0] == "format";
      if (!(is_format               ? format(words)
            : words[0] == "element" ? element(words)
                                    : words[0] == "property" && property(words)))
        throw Unsound{line_number, "", "PLY header has a line that PLY does not know",
                      "'" + std::string(line->substr(0, 60)) + "'", "correct the file; is it cut short?"};
      formatted = formatted || is_format;
    }
    throw Unsound{line_number, "", "PLY header has no end", base::counted(text_.size(), "byte") + " without end_header",
                  "restore the file: it is cut short"};
  }

  Form form = Form::text;
  std::vector<Element> elements;
  std::size_t data = 0;  ///< where the values begin
  int line_number = 0;

 private:
  /// Up to the line's end, which is \n, \r\n or, of old Macintoshes, \r; none past the text, or where a line goes on
  /// for ever.
  std::optional<std::string_view> next_line() {
    if (at_ >= text_.size()) return std::nullopt;
    const std::size_t end = text_.find_first_of("\r\n", at_);
    if (end == std::string::npos || end - at_ > kLongestLine) return std::nullopt;
    const std::string_view line = std::string_view(text_).substr(at_, end - at_);
    at_ = end + (text_.compare(end, 2, "\r\n") == 0 ? 2 : 1);
    ++line_number;
    return line;
  }

  bool format(const std::vector<std::string>& words) {
    if (words.size() < 2) return false;
    form = words[1] == "ascii" ? Form::text : words[1] == "binary_big_endian" ? Form::big_endian : Form::little_endian;
    return words[1] == "ascii" || words[1] == "binary_little_endian" || words[1] == "binary_big_endian";
  }

  bool element(const std::vector<std::string>& words) {
    if (words.size() != 3) return false;
    const auto count = parse_number(words[2]);
    if (!count || !std::isfinite(*count) || *count < 0 || *count != std::floor(*count)) return false;
    elements.push_back({line_number, words[1], words[2], *count, {}});
    return true;
  }

  bool property(const std::vector<std::string>& words) {
    const bool list = words.size() == 5 && words[1] == "list";
    if (elements.empty() || (!list && words.size() != 3)) return false;
    const auto first = type_named(words[list ? 2 : 1]), second = list ? type_named(words[3]) : first;
    if (!first || !second) return false;
    elements.back().properties.push_back({words.back(), list ? first : std::nullopt, *second});
    return true;
  }

  /// Before memory is taken for it. A value of text takes a digit and something that parts it from the next; the last
  /// one may end the file. A list has at least its length.
  void check_counts() const {
    double left = static_cast<double>(text_.size() - at_) + (form == Form::text ? 1 : 0);
    for (const Element& e : elements) {
      double least = 0;
      for (const Property& p : e.properties)
        least += form == Form::text ? 2 : static_cast<double>(bytes_of(p.count.value_or(p.type)));
      const double needed = e.count * least;
      if (needed > left)
        throw Unsound{e.line, "", "PLY header counts more than the file holds",
                      e.digits + " of '" + e.name + "' in " + base::counted(text_.size(), "byte"),
                      "restore the file: it is cut short, or its header is another file's"};
      left -= needed;
    }
  }

  const std::string& text_;
  std::size_t at_ = 0;
};

/// Values one after the other, whatever their form.
class Values {
 public:
  Values(const std::string& text, const Header& header)
      : text_(text), form_(header.form), at_(header.data), line_(header.line_number + 1) {}

  void begin(const Element& element, double number) { element_ = &element, number_ = number; }

  double next(Type type) { return form_ == Form::text ? of_text(type) : of_bytes(type); }

  /// Behind an element of text its line has ended.
  void end_element() {
    if (form_ != Form::text) return;
    skip_blanks();
    if (at_ < text_.size() && text_[at_] != '\n' && text_[at_] != '\r')
      refuse("a line holds more values than its element has", word());
  }

  /// Behind all elements there is nothing.
  void end_file() {
    const auto is_end = [&](char c) {  // DOS' mark of a text's end among blanks
      return std::isspace(static_cast<unsigned char>(c)) || (form_ == Form::text && c == '\x1a');
    };
    while (at_ < text_.size() && is_end(text_[at_])) ++at_;
    if (at_ < text_.size())
      throw Unsound{form_ == Form::text ? line_at() : 0, "", "the file goes on behind what its header counts",
                    base::counted(text_.size() - at_, "byte"), "correct the counts of its header"};
  }

  [[noreturn]] void refuse(const std::string& what, const std::string& found) const {
    throw Unsound{form_ == Form::text ? line_at() : 0, element_->name + " " + number_text(number_), what, found,
                  "restore the file, or correct its header"};
  }

 private:
  int line_at() const {
    return line_ +
           static_cast<int>(std::count(text_.begin() + static_cast<std::ptrdiff_t>(counted_),
                                       text_.begin() + static_cast<std::ptrdiff_t>(std::min(at_, text_.size())), '\n'));
  }
  void skip_blanks() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t')) ++at_;
  }
  std::string word() const {
    const std::size_t end = text_.find_first_of(" \t\r\n", at_);
    return "'" + text_.substr(at_, std::min(end, at_ + 40) - at_) + "'";
  }

  double of_text(Type type) {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
    if (at_ >= text_.size()) refuse("the file ends before what its header counts", base::counted(text_.size(), "byte"));
    const std::size_t end = std::min(text_.find_first_of(" \t\r\n", at_), text_.size());
    const auto value = parse_number(text_.substr(at_, end - at_));
    const bool whole = type != Type::float32 && type != Type::float64;
    if (!value || (whole && *value != std::floor(*value)))
      refuse(whole ? "a value is no whole number" : "a value is no number", word());
    at_ = end;
    return *value;
  }

  template <class T>
  double load() {
    if (at_ + sizeof(T) > text_.size())
      refuse("the file ends before what its header counts", base::counted(text_.size(), "byte"));
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), text_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    if ((form_ == Form::big_endian) != (std::endian::native == std::endian::big)) std::reverse(raw.begin(), raw.end());
    return static_cast<double>(std::bit_cast<T>(raw));
  }
  double of_bytes(Type type) {
    switch (type) {
      case Type::int8:
        return load<std::int8_t>();
      case Type::uint8:
        return load<std::uint8_t>();
      case Type::int16:
        return load<std::int16_t>();
      case Type::uint16:
        return load<std::uint16_t>();
      case Type::int32:
        return load<std::int32_t>();
      case Type::uint32:
        return load<std::uint32_t>();
      case Type::float32:
        return load<float>();
      default:
        return load<double>();
    }
  }

  const std::string& text_;
  Form form_;
  std::size_t at_, counted_ = at_;
  int line_;
  const Element* element_ = nullptr;
  double number_ = 0;
};

class Reader {
 public:
  Reader(const std::string& text, const Header& header) : header_(header), values_(text, header) {}

  PlyMesh read() {
    for (const Element& element : header_.elements) {
      if (element.name == "vertex") begin_vertices(element);
      const bool faces = element.name == "face", strips = element.name == "tristrips";
      indices_ = faces || strips ? element.find({"vertex_indices", "vertex_index"}) : -1;
      if (indices_ >= 0 && !element.properties[static_cast<std::size_t>(indices_)].count) indices_ = -1;
      if (element.properties.empty()) continue;
      for (double number = 0; number < element.count; ++number) {
        values_.begin(element, number);
        read_element(element);
        if (element.name == "vertex") add_vertex();
        if (indices_ >= 0 && faces) add_face();
        if (indices_ >= 0 && strips) add_strip();
        values_.end_element();
      }
    }
    values_.end_file();
    return std::move(out_);
  }

 private:
  void begin_vertices(const Element& element) {
    place_ = {element.find({"x"}), element.find({"y"}), element.find({"z"})};
    for (const int at : place_)
      if (at < 0 || element.properties[static_cast<std::size_t>(at)].count)
        throw Unsound{element.line, "", "vertices lack x, y or z", element.digits + " vertices", "give all three"};
    image_ = {element.find({"s", "u", "texture_u"}), element.find({"t", "v", "texture_v"})};
    out_.vertices.reserve(static_cast<std::size_t>(element.count));
    out_.in_image.reserve(static_cast<std::size_t>(element.count));
  }

  /// The scalars, and the list of `indices_`.
  void read_element(const Element& element) {
    scalars_.assign(element.properties.size(), 0);
    list_.clear();
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      const Property& property = element.properties[i];
      if (!property.count) {
        scalars_[i] = values_.next(property.type);
        continue;
      }
      const double count = values_.next(*property.count);
      if (!(count >= 0 && count < 4294967296.0)) values_.refuse("a list has no such length", number_text(count));
      for (double k = 0; k < count; ++k) {
        const double value = values_.next(property.type);
        if (static_cast<int>(i) == indices_) list_.push_back(value);
      }
    }
  }

  void add_vertex() {
    const auto at = [&](int place) { return scalars_[static_cast<std::size_t>(place)]; };
    out_.vertices.push_back({at(place_[0]), at(place_[1]), at(place_[2])});
    constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
    out_.in_image.push_back(image_[0] < 0 || image_[1] < 0
                                ? std::array{kNone, kNone}
                                : std::array{static_cast<float>(at(image_[0])), static_cast<float>(at(image_[1]))});
  }

  std::uint32_t corner(double value) const {
    if (!(value >= 0 && value < 4294967295.0)) values_.refuse("face index out of range", number_text(value));
    return static_cast<std::uint32_t>(value);
  }

  void add_face() {
    out_.face_corners.push_back(static_cast<std::uint32_t>(list_.size()));
    for (const double value : list_) out_.corners.push_back(corner(value));
  }

  /// Each vertex from the third on makes a triangle with the two before it; every second one turns the other way.
  void add_strip() {
    std::size_t length = 0;
    for (std::size_t i = 0; i < list_.size(); ++i) {
      if (list_[i] == -1) {
        length = 0;
        continue;
      }
      if (++length < 3) continue;
      const bool turned = length % 2 == 0;
      out_.face_corners.push_back(3);
      for (const std::size_t back :
           {turned ? std::size_t{1} : std::size_t{2}, turned ? std::size_t{2} : std::size_t{1}, std::size_t{0}})
        out_.corners.push_back(corner(list_[i - back]));
    }
  }

  const Header& header_;
  Values values_;
  PlyMesh out_;
  int indices_ = -1;
  std::array<int, 3> place_{};
  std::array<int, 2> image_{};
  std::vector<double> scalars_, list_;
};

}  // namespace

std::optional<PlyMesh> read_ply(const std::string& text, const std::string& file, Problems& problems) {
  try {
    Header header(text);
    header.read();
    return Reader(text, header).read();
  } catch (const Unsound& found) {
    problems.add({file, found.line, 0, found.element}, found.what, found.found, found.way_out);
    return std::nullopt;
  }
}

}  // namespace raycube::scene
