// SPDX-License-Identifier: Apache-2.0
#include "recognition/bop_results.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <string>

#include "estancia/core/fail.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/files/csv.hpp"
#include "estancia/files/files.hpp"
#include "recognition/bop_data.hpp"

namespace estancia::experiments {
namespace {

constexpr double perMeter = 1000;

std::vector<double> numbersIn(const std::string& cell, std::size_t count) {
  std::vector<double> numbers;
  for (const std::string_view word : io::wordsOf(cell)) {
    const auto number = io::toNumber(word);
    if (!number || !std::isfinite(*number))
      fail(ErrorCode::malformedFile, "\"{}\" is no number", io::printable(word));
    numbers.push_back(*number);
  }
  if (numbers.size() != count)
    fail(ErrorCode::malformedFile, "\"{}\" has not {} numbers", io::printable(cell), count);
  return numbers;
}

int idIn(const std::string& cell) {
  const double id = numbersIn(cell, 1)[0];
  if (!(id >= 0 && id <= 999'999 && id == std::floor(id)))
    fail(ErrorCode::malformedFile, "\"{}\" is no number of 0 … 999999", io::printable(cell));
  return static_cast<int>(id);
}

BopEstimate estimateIn(const std::vector<std::string>& cells) {
  if (cells.size() != 7) fail(ErrorCode::malformedFile, "{} columns, not 7", cells.size());
  return {idIn(cells[0]),
          idIn(cells[1]),
          idIn(cells[2]),
          numbersIn(cells[3], 1)[0],
          bopPose(numbersIn(cells[4], 9), numbersIn(cells[5], 3)),
          numbersIn(cells[6], 1)[0]};
}

}  // namespace

void writeBopResults(const std::filesystem::path& file, std::span<const BopEstimate> estimates) {
  std::string text = "scene_id,im_id,obj_id,score,R,t,time\n";
  for (const BopEstimate& one : estimates) {
    const cv::Matx33d r = one.pose.rotation();
    const cv::Vec3d t = one.pose.translation() * perMeter;
    text += fmt::format("{},{},{},{},{},{},{}\n", one.scene, one.image, one.object, one.score,
                        fmt::join(r.val, r.val + 9, " "), fmt::join(t.val, t.val + 3, " "), one.seconds);
  }
  writeWhole(file, text);
}

std::vector<BopEstimate> readBopResults(const std::filesystem::path& file) {
  std::vector<BopEstimate> estimates;
  io::forEachCsvRow(file, [&](io::CsvRow& row) {
    if (row.line == 1 && !row.cells.empty() && row.cells[0] == "scene_id") return;
    try {
      estimates.push_back(estimateIn(row.cells));
    } catch (const Error& problem) {
      fail(problem.code(), "{}:{}: {}; give scene_id,im_id,obj_id,score,R,t,time as BOP does",
           io::printable(file), row.line, problem.what());
    }
  });
  return estimates;
}

}  // namespace estancia::experiments
