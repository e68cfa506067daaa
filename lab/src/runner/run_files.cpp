// SPDX-License-Identifier: Apache-2.0
#include "runner/run_files.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cmath>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "estancia/core/cores.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/findings/result_table.hpp"
#include "estancia/version.hpp"

namespace estancia::experiments {
namespace {

ResultTable tableOf(const HeatTable& heat) {
  ResultTable table{heat.title, heat.caption, "", {}, {}};
  for (std::size_t r = 0; r < heat.names.size(); ++r) {
    table.columns.push_back({heat.names[r], heat.decimals});
    table.rows.push_back({heat.names[r], {}});
    for (std::size_t c = 0; c < heat.names.size(); ++c)
      table.rows[r].values.push_back(std::isfinite(heat.at(r, c)) ? std::optional(heat.at(r, c))
                                                                  : std::nullopt);
  }
  return table;
}

}  // namespace

std::string findingsMarkdown(const Findings& findings) {
  std::string text =
      fmt::format("# {}\n\n{}\n", escapeMarkdown(findings.title), escapeMarkdown(findings.summary));
  const auto add = [&text](const ResultTable& table) {
    text += fmt::format("\n## {}\n\n", escapeMarkdown(table.title));
    if (!table.caption.empty()) text += escapeMarkdown(table.caption) + "\n\n";
    text += markdownTable(table);
  };
  for (const auto& section : findings.sections) {
    if (const auto* table = std::get_if<ResultTable>(&section)) add(*table);
    if (const auto* heat = std::get_if<HeatTable>(&section)) add(tableOf(*heat));
  }
  return text;
}

std::string processorName(const std::string& cpuinfo) {
  std::istringstream lines(cpuinfo);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("model name") && line.find(": ") != std::string::npos)
      return line.substr(line.find(": ") + 2);
  return "";
}

void writeRunFiles(const ExperimentRun& run, const std::vector<std::filesystem::path>& configs,
                   const Findings& findings, double seconds) {
  std::ostringstream cpuinfo;
  cpuinfo << std::ifstream("/proc/cpuinfo").rdbuf();
  nlohmann::ordered_json json{{"version", version()},
                              {"date", fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)))},
                              {"processor", processorName(cpuinfo.str())},
                              {"cores", usableCores()},
                              {"configurations", nlohmann::json::array()},
                              {"models", run.models},
                              {"seconds", std::round(seconds)}};
  for (const auto& config : configs) json["configurations"].push_back(config.string());
  writeWhole(run.folder / "findings.md", findingsMarkdown(findings));
  writeWhole(run.folder / "run.json",
             json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

}  // namespace estancia::experiments
