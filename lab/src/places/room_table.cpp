// SPDX-License-Identifier: Apache-2.0
#include "places/room_table.hpp"

#include <map>

namespace estancia::experiments {

RoomTable::RoomTable(const std::filesystem::path& file, const std::string& imageColumn,
                     const std::vector<Frame>& frames)
    : table_(file), lines_(frames.size()) {
  std::map<std::string, std::size_t> frameOf;
  for (std::size_t i = 0; i < frames.size(); ++i) frameOf.emplace(imageNumber(frames[i].name), i);
  const std::size_t image = table_.column(imageColumn);
  for (const io::CsvRow& row : table_.rows())
    if (const auto frame = frameOf.find(imageNumber(row.cells[image])); frame != frameOf.end())
      lines_[frame->second] = &row;
}

std::vector<std::string> RoomTable::column(const std::string& name) const {
  const std::size_t column = table_.column(name);
  std::vector<std::string> cells;
  for (const io::CsvRow* line : lines_) cells.push_back(line == nullptr ? "" : line->cells[column]);
  return cells;
}

std::string imageNumber(const std::string& name) {
  const std::string stem = std::filesystem::path(name).stem().string();
  if (stem.empty() || stem.find_first_not_of("0123456789") != std::string::npos) return stem;
  const auto digits = stem.find_first_not_of('0');
  return digits == std::string::npos ? "0" : stem.substr(digits);
}

}  // namespace estancia::experiments
