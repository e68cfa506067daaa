// estancia cache: labels kept from earlier runs.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "common.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/label/label_stream.hpp"

namespace estancia::apps {
namespace {

void show(bool json) {
  const LabelCache cache;
  const auto usage = cache.usage();
  std::uint64_t total = 0;
  for (const auto& use : usage) total += use.bytes;
  if (json) {
    auto models = nlohmann::ordered_json::array();
    for (const auto& use : usage)
      models.push_back({{"model", use.model}, {"frames", use.images}, {"bytes", use.bytes}});
    print({{"folder", cache.folder().string()},
           {"bytes", total},
           {"limit", cache.limit()},
           {"models", models}});
    return;
  }
  for (const auto& use : usage)
    fmt::print("{:>9.1f} MB {:>9} frames  {}\n", static_cast<double>(use.bytes) / 1e6, use.images, use.model);
  fmt::print("{:.1f} of at most {:.0f} MB in {}\n", static_cast<double>(total) / 1e6,
             static_cast<double>(cache.limit()) / 1e6, printable(cache.folder().string()));
}

}  // namespace

void addCacheCommand(CLI::App& app) {
  auto json = std::make_shared<bool>(false);
  CLI::App* command = app.add_subcommand(
      "cache",
      "Show or clear the labels that are kept from earlier runs (at most ESTANCIA_CACHE_MB megabytes)");
  command->require_subcommand(1);
  addExamples(*command,
              "  estancia cache show\n"
              "  estancia cache clear");
  CLI::App* showing =
      command->add_subcommand("show", "List the models whose labels are kept, and their size");
  addJsonOption(*showing, *json);
  addExamples(*showing, "  estancia cache show");
  showing->callback([json] { show(*json); });
  CLI::App* clear = command->add_subcommand("clear", "Remove all of them");
  addJsonOption(*clear, *json);
  addExamples(*clear, "  estancia cache clear");
  clear->callback([json] {
    const auto freed = LabelCache().clear();
    if (*json)
      print({{"freed", freed}});
    else
      fmt::print("{:.1f} MB freed\n", static_cast<double>(freed) / 1e6);
  });
}

}  // namespace estancia::apps
