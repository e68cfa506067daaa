// Run files: what an experiment found and under what circumstances, beside its page, for pages of
// documentation. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "estancia/findings/findings.hpp"
#include "runner/experiment.hpp"

namespace estancia::experiments {

/// The summary and all tables as Markdown, each under a heading with its title; what is a number for each
/// pair is a table, too.
std::string findingsMarkdown(const Findings& findings);

/// Name of the processor by the text of /proc/cpuinfo; "" where it has none.
std::string processorName(const std::string& cpuinfo);

/// Writes findings.md and run.json (version, date, machine, configurations, models that replaced theirs,
/// seconds of the last call: cells that were at hand are not in them) into the run's folder.
void writeRunFiles(const ExperimentRun& run, const std::vector<std::filesystem::path>& configs,
                   const Findings& findings, double seconds);

}  // namespace estancia::experiments
