#include "experiments/src/places/room_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "estancia/core/error.hpp"
#include "estancia/io/csv.hpp"

namespace estancia::experiments {

RoomTable::RoomTable(std::filesystem::path file, const std::string& imageColumn,
                     const std::vector<Frame>& frames)
    : file_(std::move(file)), lines_(frames.size()) {
  auto rows = io::readCsv(file_);
  if (rows.empty()) throw Error(fmt::format("{}: an empty table", file_.string()));
  header_ = rows[0].cells;
  const std::size_t image = numberOf(imageColumn);
  std::map<std::string, std::size_t> frameOf;
  for (std::size_t i = 0; i < frames.size(); ++i) frameOf.emplace(imageNumber(frames[i].name), i);
  for (std::size_t r = 1; r < rows.size(); ++r) {
    auto& cells = rows[r].cells;
    if (cells.size() != header_.size())
      throw Error(fmt::format("{}:{}: {} cells under a header of {}", file_.string(), rows[r].line,
                              cells.size(), header_.size()));
    const auto frame = frameOf.find(imageNumber(cells[image]));
    if (frame != frameOf.end()) lines_[frame->second] = std::move(cells);
  }
}

std::vector<std::string> RoomTable::column(const std::string& name) const {
  const std::size_t number = numberOf(name);
  std::vector<std::string> cells;
  for (const auto& line : lines_) cells.push_back(line.empty() ? "" : line[number]);
  return cells;
}

std::size_t RoomTable::numberOf(const std::string& column) const {
  const auto found = std::find(header_.begin(), header_.end(), column);
  if (found == header_.end())
    throw Error(fmt::format("{}:1: there is no column `{}`; there are {}", file_.string(), column,
                            fmt::join(header_, ", ")));
  return static_cast<std::size_t>(found - header_.begin());
}

std::string imageNumber(const std::string& name) {
  const std::string stem = std::filesystem::path(name).stem().string();
  if (stem.empty() || stem.find_first_not_of("0123456789") != std::string::npos) return stem;
  const auto digits = stem.find_first_not_of('0');
  return digits == std::string::npos ? "0" : stem.substr(digits);
}

}  // namespace estancia::experiments
