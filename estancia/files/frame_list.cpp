// SPDX-License-Identifier: Apache-2.0
#include "estancia/files/frame_list.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <optional>

#include "estancia/core/fail.hpp"
#include "estancia/files/csv.hpp"
#include "estancia/files/files.hpp"

namespace estancia::io {
namespace fs = std::filesystem;
namespace {

constexpr std::array<const char*, 7> poseKeys = {"x", "y", "z", "qx", "qy", "qz", "qw"};

/// A row's cells by the names of their columns.
class Row {
 public:
  Row(const CsvRow& row, const std::vector<std::string>& columns, std::string where)
      : row_(row), columns_(columns), where_(std::move(where)) {}

  std::string text(const std::string& column) const {
    const auto found = findColumn(columns_, column);
    return found ? printable(row_.cells[*found]) : "";
  }

  std::optional<double> number(const std::string& column) const {
    const std::string cell = text(column);
    if (cell.empty()) return std::nullopt;
    const auto value = toNumber(cell);
    if (!value || !std::isfinite(*value))
      fail(ErrorCode::malformedFile, "{}: {} is \"{}\", not a finite number", where_, column, cell);
    return value;
  }

  std::optional<Pose> pose() const {
    std::array<double, 7> values{};
    std::size_t known = 0;
    for (std::size_t i = 0; i < values.size(); ++i)
      if (const auto value = number(poseKeys[i])) {
        values[i] = *value;
        ++known;
      }
    if (known == 0) return std::nullopt;
    const double norm = std::hypot(std::hypot(values[3], values[4]), std::hypot(values[5], values[6]));
    if (known < values.size() || std::abs(norm - 1) > 0.01)
      fail(ErrorCode::malformedFile,
           "{}: incomplete pose or no unit quaternion; give x, y, z [m], qx, qy, qz, qw", where_);
    const Pose pose{values[0], values[1], values[2], values[3], values[4], values[5], values[6]};
    if (!pose.isPlausible())
      fail(ErrorCode::malformedFile, "{}: a position beyond 10 000 km; give x, y, z in meters", where_);
    return pose;
  }

 private:
  const CsvRow& row_;
  const std::vector<std::string>& columns_;
  std::string where_;
};

}  // namespace

void UniqueNames::add(const std::string& name, const fs::path& file, std::size_t line) {
  const std::string where = fmt::format("{}:{}", printable(file), line);
  if (name.empty()) fail(ErrorCode::malformedFile, "{}: the image has no name", where);
  const auto [entry, isNew] = lines_.emplace(name, line);
  if (!isNew)
    fail(ErrorCode::malformedFile, "{}: {} is repeated from line {}; keep one of them", where, name,
         entry->second);
}

std::vector<Frame> readFrameList(const fs::path& file) {
  std::vector<std::string> columns;
  std::vector<Frame> frames;
  UniqueNames names;
  forEachCsvRow(file, [&](CsvRow& row) {
    const std::string where = fmt::format("{}:{}", printable(file), row.line);
    if (columns.empty()) {
      const bool header = findColumn(row.cells, "image").has_value();
      columns = header ? row.cells : std::vector<std::string>{"image"};
      if (header) return;
    }
    if (row.cells.size() != columns.size())
      fail(ErrorCode::malformedFile, "{}: {} cells instead of {}{}", where, row.cells.size(), columns.size(),
           columns.size() == 1 ? "; give one name per line, or a header with `image`" : "");
    const Row cells(row, columns, where);
    Frame frame{cells.text("image"), cells.number("timestamp"), cells.pose(), cells.text("room")};
    names.add(frame.name, file, row.line);
    frames.push_back(std::move(frame));
  });
  return frames;
}

std::string frameListText(const std::vector<Frame>& frames) {
  std::string text = "image,timestamp,x,y,z,qx,qy,qz,qw,room\n";
  for (const Frame& frame : frames) {
    text += csvCell(frame.name) + ',';
    if (frame.timestamp) text += fmt::format("{}", *frame.timestamp);
    if (const auto& p = frame.pose)
      text += fmt::format(",{},{},{},{},{},{},{}", p->x, p->y, p->z, p->qx, p->qy, p->qz, p->qw);
    else
      text.append(poseKeys.size(), ',');
    text += ',' + csvCell(frame.room) + '\n';
  }
  return text;
}

}  // namespace estancia::io
