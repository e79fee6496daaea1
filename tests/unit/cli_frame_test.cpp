// The command-line frame: one option table feeds parser, help, man page and --json-usage (DESIGN section 10; S56's
// knobs are options). Oracle: the table itself, and a JSON parser that is not ours.
#include <doctest/doctest.h>

#include <memory>

#include <nlohmann/json.hpp>

#include "host/base/error.h"
#include "host/cli/parser.h"
#include "host/cli/usage.h"

using namespace raycube;
using base::Error;

namespace {

struct Values {
  std::string file;
  std::vector<std::string> extra;
  double gsd_m = 1;
  int count = 3;
  std::string interleave = "bip";
  std::uint64_t cache_bytes = 1 << 20;
};

std::vector<cli::Verb> example_verbs(const std::shared_ptr<Values>& o) {
  cli::Verb verb("measure", "Measure a file");
  verb.common = cli::kOutput | cli::kSeed;
  verb.add_options = [o](base::OptionTable& table) {
    table.argument("FILE", "What to measure", o->file);
    table.number("-g,--gsd", "m", 0.5, 100, "Ground sample distance", o->gsd_m);
    table.integer("--count", "", 1, 9, "How often", o->count);
    table.choice("--interleave", {"bip", "bil", "bsq"}, "Order of the samples", o->interleave);
    table.memory("--cache", "Size of the cache", o->cache_bytes);
    table.texts("--extra", "NAME", "Another name", o->extra);
  };
  verb.run = [](cli::Invocation&) { return 0; };
  cli::Verb inner = verb;
  inner.name = "build";
  inner.summary = "Build a table";
  cli::Verb group("atmos", "Tables");
  group.verbs = {inner};
  return {verb, group};
}

cli::Parsed parse(std::vector<const char*> words, const std::vector<cli::Verb>& verbs, cli::CommonOptions& values) {
  words.insert(words.begin(), "raycube");
  return cli::parse_command_line(static_cast<int>(words.size()), words.data(), verbs, values);
}

std::string error_of(std::vector<const char*> words) {
  const auto verbs = example_verbs(std::make_shared<Values>());
  cli::CommonOptions values;
  try {
    parse(std::move(words), verbs, values);
  } catch (const Error& error) {
    CHECK(error.exit_status() == 2);
    return error.what();
  }
  return "";
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("values reach the bound variables") {
  const auto o = std::make_shared<Values>();
  const auto verbs = example_verbs(o);
  cli::CommonOptions values;
  const auto parsed =
      parse({"measure", "a.img", "--gsd", "2.5", "--count=9", "--interleave", "bsq", "--cache", "3K", "--extra", "x",
             "--extra", "y", "-vv", "--seed", "18446744073709551615", "-o", "out", "--json"},
            verbs, values);
  REQUIRE(parsed.verb != nullptr);
  CHECK(parsed.verb->name == "measure");
  CHECK(o->file == "a.img");
  CHECK(o->gsd_m == 2.5);
  CHECK(o->count == 9);
  CHECK(o->interleave == "bsq");
  CHECK(o->cache_bytes == 3072);
  CHECK(o->extra == std::vector<std::string>{"x", "y"});
  CHECK(values.verbose == 2);
  CHECK(values.seed == 18446744073709551615ull);
  CHECK(values.output == "out");
  CHECK(values.json);
}

TEST_CASE("second-level verbs parse and keep their own options") {
  const auto o = std::make_shared<Values>();
  const auto verbs = example_verbs(o);
  cli::CommonOptions values;
  const auto parsed = parse({"atmos", "build", "t.rct", "-g", "3"}, verbs, values);
  REQUIRE(parsed.verb != nullptr);
  CHECK(parsed.verb->name == "build");
  CHECK(o->gsd_m == 3);
}

TEST_CASE("bad usage: each mistake has one message that names option, rule, value and way out") {
  CHECK(contains(error_of({"measure", "a", "--gsd", "0.4"}), "--gsd must be 0.5 to 100 (found \"0.4\")"));
  CHECK(contains(error_of({"measure", "a", "--gsd", "nan"}), "--gsd must be a finite number (found \"nan\")"));
  CHECK(contains(error_of({"measure", "a", "--gsd", "2x"}), "--gsd must be a number (found \"2x\")"));
  CHECK(contains(error_of({"measure", "a", "--count", "10"}), "--count must be 1 to 9 (found \"10\")"));
  CHECK(contains(error_of({"measure", "a", "--count", "99999999999"}), "--count must be a whole number"));
  CHECK(contains(error_of({"measure", "a", "--seed", "-1"}), "--seed must be a whole number"));
  CHECK(contains(error_of({"measure", "a", "--interleave", "bpi"}),
                 "--interleave must be one of bip, bil, bsq (found \"bpi\")"));
  CHECK(contains(error_of({"measure", "a", "--cache", "12Q"}), "--cache: unknown unit of memory (found \"12Q\")"));
  CHECK(contains(error_of({"measure", "a", "--interlave", "bip"}),
                 "has no option --interlave; did you mean --interleave?"));
  CHECK(contains(error_of({"measure", "a", "--device", "0"}), "has no option --device"));
  CHECK(contains(error_of({"measure", "a", "b"}), "takes no further argument (found \"b\")"));
  CHECK(contains(error_of({"measure"}), "FILE is required"));
  CHECK(contains(error_of({"mesure"}), "unknown verb \"mesure\"; did you mean measure?"));
  CHECK(contains(error_of({"atmos", "biuld"}), "unknown verb \"biuld\"; did you mean build?"));
  CHECK(contains(error_of({"atmos"}), "name a verb of atmos: build"));
  CHECK(contains(error_of({}), "name a verb: measure, atmos"));
  CHECK(contains(error_of({"--versoin"}), "did you mean --version?"));
  CHECK(contains(error_of({"measure", "a", "-q", "-v"}), "contradict"));
}

TEST_CASE("help, man page and --json-usage list every row of the table") {
  const auto verbs = example_verbs(std::make_shared<Values>());
  cli::CommonOptions values;
  const std::string help = parse({"measure", "--help"}, verbs, values).text;
  const std::string manual = cli::man_page(verbs);
  const auto usage = nlohmann::json::parse(parse({"--json-usage"}, verbs, values).text);
  const auto& options = usage["verbs"][0]["options"];
  const auto rows = cli::table_of(verbs[0], values).rows();
  REQUIRE(options.size() == rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    CAPTURE(rows[i].names);
    CHECK(contains(help, rows[i].long_name()));
    CHECK(contains(help, rows[i].help));
    std::string escaped;
    for (const char c : rows[i].long_name()) escaped += c == '-' ? "\\-" : std::string(1, c);
    CHECK(contains(manual, escaped));
    CHECK(options[i]["names"].back() == rows[i].long_name());
    CHECK(options[i]["help"] == rows[i].help);
  }
  CHECK(options[1]["unit"] == "m");
  CHECK(options[1]["default"] == "1");
  CHECK(options[1]["range"] == "0.5 to 100");
  CHECK(contains(help, "[m; 0.5 to 100; default 1]"));
  CHECK(contains(parse({"--help"}, verbs, values).text, "measure"));
  CHECK(contains(parse({"atmos", "build", "--help"}, verbs, values).text, "Usage: raycube atmos build"));
  CHECK(contains(parse({"--version"}, verbs, values).text, "raycube 0."));
}
