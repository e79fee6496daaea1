#include "host/cli/parser.h"

#include <deque>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/version.h"
#include "host/cli/usage.h"

namespace raycube::cli {
namespace {

using base::Error;
using base::Fault;

/// A verb wired into CLI11. Rows hand their text to Option::set, so that every message has one form.
struct Node {
  const Verb* verb;
  std::string path;
  CLI::App* app;
  base::OptionTable table;
};

void wire(CLI::App& parent, const Verb& verb, const std::string& path, CommonOptions& values, std::deque<Node>& nodes) {
  CLI::App* app = parent.add_subcommand(verb.name, verb.summary);
  app->set_help_flag("-h,--help");
  Node& node = nodes.emplace_back(Node{&verb, path, app, {}});
  if (!verb.run) {
    for (const auto& child : verb.verbs) wire(*app, child, path + " " + child.name, values, nodes);
    return;
  }
  node.table = table_of(verb, values);
  for (const auto& row : node.table.rows()) {
    if (!row.takes_value()) {
      app->add_flag_function(row.names, [&row](std::int64_t times) {
        for (std::int64_t i = 0; i < times; ++i) row.set("");
      });
      continue;
    }
    auto* option =
        app->add_option_function<std::vector<std::string>>(row.names, [&row](const std::vector<std::string>& typed) {
          for (const auto& text : typed) row.set(text);
        });
    option->required(row.required)->allow_extra_args(row.repeats && row.positional);
    if (row.repeats) {
      if (!row.positional) option->expected(1)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    } else {
      option->expected(1)->multi_option_policy(CLI::MultiOptionPolicy::Throw);
    }
  }
}

std::vector<std::string> option_names(const base::OptionTable& table) {
  std::vector<std::string> names = {"--help"};
  for (const auto& row : table.rows())
    if (!row.positional) names.push_back(row.long_name());
  return names;
}

std::string did_you_mean(const std::string& typed, const std::vector<std::string>& names) {
  const std::string near = nearest(typed, names);
  return near.empty() ? "" : "did you mean " + near + "? ";
}

std::vector<std::string> names_of(const std::vector<Verb>& verbs) {
  std::vector<std::string> names;
  for (const auto& verb : verbs) names.push_back(verb.name);
  return names;
}

/// The innermost verb that was named.
const Node* named(const std::deque<Node>& nodes) {
  const Node* found = nullptr;
  for (const auto& node : nodes)
    if (node.app->parsed()) found = &node;
  return found;
}

[[noreturn]] void unknown_verb(const std::string& typed, const std::string& path, const std::vector<Verb>& verbs) {
  const auto names = names_of(verbs);
  throw Error(Fault::input, fmt::format("unknown verb \"{}\"; {}verbs{}: {}", typed, did_you_mean(typed, names),
                                        path.empty() ? "" : " of " + path, fmt::join(names, ", ")));
}

[[noreturn]] void unexpected(const std::string& typed, const Node& node) {
  const std::string see = fmt::format("see raycube {} --help", node.path);
  if (!node.verb->run) unknown_verb(typed, node.path, node.verb->verbs);
  if (typed.rfind("-", 0) == 0) {
    const std::string name = typed.substr(0, typed.find('='));
    throw Error(Fault::input, fmt::format("raycube {} has no option {}; {}{}", node.path, name,
                                          did_you_mean(name, option_names(node.table)), see));
  }
  throw Error(Fault::input,
              fmt::format("raycube {} takes no further argument (found \"{}\"); {}", node.path, typed, see));
}

}  // namespace

Parsed parse_command_line(int argc, const char* const* argv, const std::vector<Verb>& verbs, CommonOptions& values) {
  CLI::App app("", "raycube");
  bool version = false, usage = false, manual = false;
  app.set_help_flag("-h,--help");
  app.add_flag("--version", version);
  app.add_flag("--json-usage", usage);
  app.add_flag("--man-page", manual);  // for the build, which installs the result
  app.require_subcommand(0, 1);
  std::deque<Node> nodes;
  for (const auto& verb : verbs) wire(app, verb, verb.name, values, nodes);

  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    const Node* node = named(nodes);
    // "help nonsense", "scene nonsense --help": what there is no help of is told.
    const auto extras = node ? node->app->remaining() : app.remaining();
    const bool wants_verb = !node || !node->verb->run;
    if (wants_verb && !extras.empty() && extras.front().rfind("-", 0) != 0)
      unknown_verb(extras.front(), node ? node->path : "", node ? node->verb->verbs : verbs);
    return {nullptr, node ? verb_help(node->path, *node->verb) : program_help(verbs)};
  } catch (const CLI::ExtrasError&) {
    const Node* node = named(nodes);
    const auto extras = node && !node->app->remaining().empty() ? node->app->remaining() : app.remaining();
    const std::string typed = extras.empty() ? "" : extras.front();
    if (node) unexpected(typed, *node);
    if (typed.rfind("-", 0) == 0)
      throw Error(Fault::input, fmt::format("raycube has no option {}; {}see raycube --help", typed,
                                            did_you_mean(typed, {"--help", "--version", "--json-usage"})));
    unknown_verb(typed, "", verbs);
  } catch (const CLI::ParseError& failure) {
    const Node* node = named(nodes);
    throw Error(Fault::input, fmt::format("{}; see raycube {}--help", failure.what(), node ? node->path + " " : ""));
  }
  if (version)
    return {nullptr, fmt::format("raycube {} (commit {}; {})\n", base::kVersion, base::kCommit, base::kCompiler)};
  if (usage) return {nullptr, json_usage(verbs)};
  if (manual) return {nullptr, man_page(verbs)};
  const Node* node = named(nodes);
  if (!node)
    throw Error(Fault::input, fmt::format("name a verb: {}; see raycube --help", fmt::join(names_of(verbs), ", ")));
  if (!node->verb->run)
    throw Error(Fault::input,
                fmt::format("name a verb of {}: {}", node->path, fmt::join(names_of(node->verb->verbs), ", ")));
  if (values.quiet > 0 && values.verbose > 0)
    throw Error(Fault::input, "--quiet and --verbose contradict each other; give one");
  return {node->verb, ""};
}

}  // namespace raycube::cli
