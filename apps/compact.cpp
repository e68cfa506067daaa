// estancia compact: a smaller map file.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>
#include <optional>

#include "common.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/session/session.hpp"

namespace estancia::apps {
namespace {

struct CompactArguments {
  std::string map;
  std::optional<std::uint64_t> budget;
  bool json = false;
};

void run(const CompactArguments& arguments) {
  const CompactedMap done = compactMap(arguments.map, arguments.budget);
  if (arguments.json)
    return print({{"map", arguments.map},
                  {"bytes_before", done.bytesBefore},
                  {"bytes_after", done.bytesAfter},
                  {"frames_before", done.framesBefore},
                  {"frames_after", done.framesAfter}});
  const auto megabytes = [](std::uintmax_t bytes) { return static_cast<double>(bytes) / 1e6; };
  fmt::print("{}: {:.1f} MB, before {:.1f} MB; {} of {} frames are kept\n", printable(arguments.map),
             megabytes(done.bytesAfter), megabytes(done.bytesBefore), done.framesAfter, done.framesBefore);
}

}  // namespace

void addCompactCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "compact",
      "Make a map file smaller: unused space is given back, and images that say least are left out");
  auto arguments = std::make_shared<CompactArguments>();
  command->add_option("MAP", arguments->map, "The map file")->required();
  command
      ->add_option("--file-budget", arguments->budget,
                   "Most megabytes of the file: of the places with most images, those that say least beside "
                   "the others are left out; places, objects, areas, names and corrections stay")
      ->type_name("MB")
      ->check(wholeNumber(1));
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia compact home.estancia\n"
              "  estancia compact home.estancia --file-budget 100");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace estancia::apps
