// SPDX-License-Identifier: Apache-2.0
#include "runner/grid.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "estancia/core/cores.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/files/csv.hpp"
#include "estancia/files/files.hpp"
#include "estancia/processes/work_queue.hpp"

namespace estancia::experiments {
namespace fs = std::filesystem;
namespace {

constexpr int cellVersion = 2;
constexpr std::size_t maxCellBytes = 16 << 20;

}  // namespace

std::optional<double> valueOf(const CellResults& results, const std::string& measure, const std::string& at) {
  const auto found = std::find_if(results.begin(), results.end(),
                                  [&](const auto& r) { return r.measure == measure && r.at == at; });
  return found == results.end() ? std::nullopt : std::optional(found->value);
}

Grid::Grid(fs::path folder, GridColumns columns, int threads, WorkQueue* distribution)
    : folder_(std::move(folder)),
      columns_(std::move(columns)),
      threads_(static_cast<std::size_t>(threads > 0               ? threads
                                        : distribution != nullptr ? 1
                                                                  : usableCores())),
      distribution_(distribution) {}

fs::path Grid::fileOf(const Cell& cell) const {
  return folder_ / "cells" /
         (sha256(nlohmann::json{cell.coordinates, cell.inputs}.dump(-1, ' ', false,
                                                                    nlohmann::json::error_handler_t::replace))
              .substr(0, 32) +
          ".json");
}

std::optional<CellResults> Grid::load(const Cell& cell) const {
  const fs::path file = fileOf(cell);
  if (!fs::is_regular_file(file)) return std::nullopt;
  try {
    const auto json = nlohmann::json::parse(io::readBytes(file, maxCellBytes));
    if (json.at("estancia_cell") != cellVersion || json.at("inputs") != cell.inputs) return std::nullopt;
    CellResults results;
    for (const auto& entry : json.at("results"))
      results.push_back(
          {entry.at(0).get<std::string>(), entry.at(1).get<std::string>(), entry.at(2).get<double>()});
    return results;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  } catch (const Error&) {
    return std::nullopt;
  }
}

void Grid::store(const Cell& cell, const CellResults& results) const {
  nlohmann::ordered_json json{
      {"estancia_cell", cellVersion}, {"cell", cell.coordinates}, {"inputs", cell.inputs}};
  auto& list = json["results"] = nlohmann::json::array();
  for (const CellResult& result : results) list.push_back({result.measure, result.at, result.value});
  writeWhole(fileOf(cell), json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

void Grid::makeFolder() const {
  std::error_code problem;
  for (const char* file : {"results.csv", "report.html"})
    if (fs::exists(folder_ / file, problem) && !fs::exists(folder_ / "cells", problem))
      throw Error(ErrorCode::fileExists,
                  fmt::format("{}: {} is there, and not of an experiment; give another folder by -o",
                              folder_.string(), file));
  fs::create_directories(folder_ / "cells", problem);
  if (problem)
    throw Error(ErrorCode::fileUnwritable,
                fmt::format("{}: the folder cannot be made ({})", folder_.string(), problem.message()));
  for (const fs::path& folder : {folder_, folder_ / "cells"})
    if (access(folder.c_str(), W_OK | X_OK) != 0)
      throw Error(ErrorCode::fileUnwritable,
                  fmt::format("{}: the folder cannot be written ({}); give another one by -o",
                              folder.string(), std::strerror(errno)));
}

bool Grid::has(const Cell& cell) {
  const std::string name = fileOf(cell).filename().string();
  if (known_.contains(name)) return true;
  auto loaded = load(cell);
  if (loaded) known_[name] = std::move(*loaded);
  return loaded.has_value();
}

void Grid::name(const std::vector<std::string>& coordinates) {
  if (coordinates.size() != columns_.coordinates.size())
    throw Error(ErrorCode::invalidInput,
                fmt::format("a cell with {} coordinates in a grid of {}", coordinates.size(),
                            fmt::join(columns_.coordinates, ", ")));
  const auto [named, isNew] = named_.emplace(coordinates, source_);
  if (!isNew)
    throw Error(ErrorCode::invalidInput,
                fmt::format("the {} {} are there twice{}; give them different names",
                            fmt::join(columns_.coordinates, ", "), fmt::join(coordinates, ", "),
                            source_.empty() ? "" : fmt::format(", in {} and in {}", named->second, source_)));
}

/// Takes what another process has stored, which a folder on a network may show a little later.
void Grid::fetch(const Cell& cell) {
  constexpr int tries = 300;
  for (int i = 0; !has(cell); ++i) {
    if (i == tries)
      throw Error(
          ErrorCode::fileNotFound,
          fmt::format("{}: what another process has written is not to be seen; do all processes share "
                      "this folder?",
                      fileOf(cell).string()));
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
}

std::vector<CellResults> Grid::run(const std::vector<Cell>& cells,
                                   const std::function<CellResults(std::size_t)>& compute, Progress& progress,
                                   const std::string& what) {
  makeFolder();
  std::vector<std::size_t> missing;
  std::string list;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    name(cells[i].coordinates);
    list += fileOf(cells[i]).filename().string();
    if (!has(cells[i])) missing.push_back(i);
  }
  std::mutex mutex;
  std::size_t done = cells.size() - missing.size();
  const auto work = [&](std::size_t i) {
    const Cell& cell = cells[i];
    if (interrupted()) throw Interrupted("");
    CellResults results = compute(i);
    for (const CellResult& result : results)
      if (!std::isfinite(result.value))
        throw Error(ErrorCode::invalidInput,
                    fmt::format("{} of {} is not finite", result.measure, fmt::join(cell.coordinates, ", ")));
    const std::lock_guard lock(mutex);
    store(cell, results);
    known_[fileOf(cell).filename().string()] = std::move(results);
    ++done;
    progress.advance();
  };
  if (!missing.empty()) progress.begin(what, cells.size(), done);
  try {
    if (distribution_ != nullptr)
      distribution_->each(sha256(list), missing, threads_, work, [&] {
        const std::lock_guard lock(mutex);
        ++done;
        progress.advance();
      });
    else
      inParallel(missing.size(), threads_, [&](std::size_t m) { work(missing[m]); });
  } catch (const Interrupted&) {
    throw Interrupted(
        fmt::format("stopped after {} of {} cells; the same command goes on from there", done, cells.size()));
  }
  if (!missing.empty()) progress.end();
  std::vector<CellResults> all;
  for (const Cell& cell : cells) {
    fetch(cell);
    all.push_back(known_.at(fileOf(cell).filename().string()));
    table_.emplace_back(cell.coordinates, all.back());
  }
  return all;
}

void Grid::add(const std::vector<std::string>& coordinates, const CellResults& results) {
  name(coordinates);
  table_.emplace_back(coordinates, results);
}

void Grid::writeCsv(const std::string& name) const {
  if (distribution_ != nullptr && !distribution_->isFirst()) return;
  std::vector<std::string> head = columns_.order;
  if (head.empty()) {
    head = columns_.coordinates;
    if (!columns_.at.empty()) head.push_back(columns_.at);
    head.insert(head.end(), columns_.measures.begin(), columns_.measures.end());
  }
  std::string text = fmt::format("{}\n", fmt::join(head, ","));
  for (const auto& [coordinates, results] : table_) {
    std::vector<std::string> points;  // in the order of the results
    std::map<std::string, std::map<std::string, double>> values;
    for (const CellResult& result : results) {
      if (std::find(columns_.measures.begin(), columns_.measures.end(), result.measure) ==
          columns_.measures.end())
        continue;
      if (!values.contains(result.at)) points.push_back(result.at);
      values[result.at][result.measure] = result.value;
    }
    for (const std::string& point : points) {
      std::map<std::string, std::string> row{{columns_.at, io::csvCell(point)}};
      for (const auto& [measure, value] : values[point]) row[measure] = fmt::format("{}", value);
      for (std::size_t c = 0; c < coordinates.size(); ++c)
        row[columns_.coordinates[c]] = io::csvCell(coordinates[c]);
      for (std::size_t c = 0; c < head.size(); ++c) text += (c > 0 ? "," : "") + row[head[c]];
      text += "\n";
    }
  }
  writeWhole(folder_ / name, text);
}

}  // namespace estancia::experiments
