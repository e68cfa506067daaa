// SPDX-License-Identifier: Apache-2.0
#include "estancia/readers/object_samples.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <string_view>
#include <unordered_map>

#include "estancia/core/fail.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/files/cloud_file.hpp"
#include "estancia/files/csv.hpp"
#include "estancia/files/files.hpp"
#include "estancia/files/image_file.hpp"
#include "estancia/readers/object_view_formats.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view kindLine = "# estancia object samples ", kindVersion = "1";
constexpr std::string_view headerLine = "name,instance,category,split,frame,x,y,width,height,flat,at_border";
constexpr std::size_t columns = 11;

fs::path listOf(const fs::path& folder) {
  return folder / "samples.csv";
}

/// Why `name` cannot be a file name in its folder; "" when it can.
std::string nameProblem(const std::string& name) {
  constexpr std::size_t maxBytes = 200;  // file systems allow 255, with extensions and temporary names
  if (name.empty() || name.starts_with('.')) return "is empty or starts with a dot";
  if (name.size() > maxBytes) return fmt::format("has more than {} bytes", maxBytes);
  if (name.find_first_of("/\\") != std::string::npos) return "leaves the folder";
  return io::printable(name) == name ? "" : "has control characters or invalid UTF-8";
}

int pixelsOf(const std::string& cell, int min, const char* column) {
  constexpr int max = 65535;
  int value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size() || value < min || value > max)
    fail(ErrorCode::malformedFile, "{} is \"{}\"; give a whole number from {} to {}", column,
         io::printable(cell), min, max);
  return value;
}

bool flagOf(const std::string& cell, const char* column) {
  if (cell != "0" && cell != "1")
    fail(ErrorCode::malformedFile, "{} is \"{}\"; give 0 or 1", column, io::printable(cell));
  return cell == "1";
}

ObjectSample sampleOf(std::vector<std::string>& cells) {
  if (cells.size() != columns)
    fail(ErrorCode::malformedFile, "{} cells instead of {}", cells.size(), columns);
  if (const std::string wrong = nameProblem(cells[0]); !wrong.empty())
    fail(ErrorCode::malformedFile, "the name \"{}\" {}", io::printable(cells[0]), wrong);
  if (cells[1].empty()) throw Error(ErrorCode::malformedFile, "the instance is empty");
  ObjectSample sample;
  sample.box = {pixelsOf(cells[5], 0, "x"), pixelsOf(cells[6], 0, "y"), pixelsOf(cells[7], 1, "width"),
                pixelsOf(cells[8], 1, "height")};
  sample.view = {.name = cells[0],
                 .instance = io::printable(cells[1]),
                 .category = io::printable(cells[2]),
                 .split = io::printable(cells[3]),
                 .frame = io::printable(cells[4]),
                 .flat = flagOf(cells[9], "flat"),
                 .atBorder = flagOf(cells[10], "at_border")};
  return sample;
}

std::vector<std::string> cellsOf(const ObjectSample& sample) {
  const auto& [view, box] = sample;
  std::vector<std::string> cells = {view.name, view.instance, view.category, view.split, view.frame};
  for (const int number : {box.x, box.y, box.width, box.height, int{view.flat}, int{view.atBorder}})
    cells.push_back(std::to_string(number));
  return cells;
}

}  // namespace

std::vector<ObjectSample> readObjectSamples(const fs::path& folder) {
  const fs::path file = listOf(folder);
  std::vector<ObjectSample> samples;
  std::unordered_map<std::string, std::size_t> lines;
  std::size_t rows = 0;
  const auto use = [&](io::CsvRow& row) {
    if (rows == 0) {
      const std::string& kind = row.cells[0];
      if (row.cells.size() != 1 || !kind.starts_with(kindLine))
        fail(ErrorCode::unsupportedFile, "not a list of object samples, which starts with `{}{}`", kindLine,
             kindVersion);
      if (kind.substr(kindLine.size()) != kindVersion)
        fail(ErrorCode::unsupportedFile, "list of version \"{}\"; this program reads version {}",
             io::printable(kind.substr(kindLine.size())), kindVersion);
    } else if (rows == 1) {
      std::string header;
      for (const std::string& cell : row.cells) header += (header.empty() ? "" : ",") + cell;
      if (header != headerLine) fail(ErrorCode::malformedFile, "the columns must be {}", headerLine);
    } else {
      ObjectSample sample = sampleOf(row.cells);
      const auto [entry, isNew] = lines.emplace(sample.view.name, row.line);
      if (!isNew)
        fail(ErrorCode::malformedFile, "{} is repeated from line {}; keep one of them", sample.view.name,
             entry->second);
      samples.push_back(std::move(sample));
    }
    ++rows;
  };
  io::forEachCsvRow(file, [&](io::CsvRow& row) {
    try {
      use(row);
    } catch (const Error& error) {
      fail(error.code(), "{}:{}: {}", io::printable(file), row.line, error.what());
    }
  });
  if (rows < 2) fail(ErrorCode::truncatedFile, "{}: truncated, without a header", io::printable(file));
  return samples;
}

void writeObjectSamples(const std::vector<ObjectSample>& samples, const fs::path& folder) {
  std::string text = fmt::format("{}{}\n{}\n", kindLine, kindVersion, headerLine);
  std::unordered_map<std::string, std::size_t> seen;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    std::vector<std::string> cells = cellsOf(samples[i]);
    try {
      sampleOf(cells);  // what is written can be read
      if (!seen.emplace(cells[0], i).second) throw Error(ErrorCode::invalidInput, "repeated name");
      for (const std::string& cell : cells)
        if (io::printable(cell) != cell)
          throw Error(ErrorCode::invalidInput, "a text has control characters or invalid UTF-8");
    } catch (const Error& error) {
      fail(ErrorCode::invalidInput, "sample {} ({}) cannot be written: {}", i, io::printable(cells[0]),
           error.what());
    }
    for (std::size_t c = 0; c < cells.size(); ++c) text += (c == 0 ? "" : ",") + io::csvCell(cells[c]);
    text += '\n';
  }
  writeWhole(listOf(folder), text);
}

bool isObjectSamples(const fs::path& folder) {
  return fs::is_regular_file(listOf(folder)) && io::firstBytes(listOf(folder), kindLine.size()) == kindLine;
}

fs::path imageOf(const fs::path& folder, const std::string& name) {
  return folder / "images" / (name + ".png");
}

fs::path maskOf(const fs::path& folder, const std::string& name) {
  return folder / "masks" / (name + ".png");
}

fs::path cloudOf(const fs::path& folder, const std::string& name) {
  return folder / "clouds" / (name + ".pcd");
}

fs::path labelFileOf(const fs::path& folder) {
  return folder / "words.labels";
}

namespace io {
namespace {

class SampleViews final : public ListedObjectViews {
 public:
  SampleViews(const fs::path& folder, const ObjectViewsOptions& options)
      : ListedObjectViews(nameOf(folder), options.minPoints), folder_(folder) {
    const std::vector<ObjectSample> samples = readObjectSamples(folder);
    LeftOut leftOut;
    for (const ObjectSample& sample : samples) {
      const fs::path files[] = {estancia::imageOf(folder, sample.view.name),
                                estancia::cloudOf(folder, sample.view.name)};
      const auto* missing =
          std::ranges::find_if(files, [](const fs::path& f) { return !fs::is_regular_file(f); });
      if (missing != std::end(files)) {
        leftOut.add(fmt::format("{} is missing", printable(missing->string())));
        continue;
      }
      boxes_.push_back(sample.box);
      add(sample.view);
    }
    if (!leftOut.none()) warn(leftOut.sentence(samples.size(), "samples"));
  }

  PointCloud cloud(std::size_t i) const override {
    return enough(readCloud(estancia::cloudOf(folder_, view(i).name)), view(i).name);
  }

  ObjectImage image(std::size_t i) const override {
    const fs::path file = estancia::imageOf(folder_, view(i).name);
    ObjectImage seen{readImage(file), boxes_[i], {}};
    if ((seen.box & cv::Rect({}, seen.image.size())) != seen.box)
      fail(ErrorCode::mismatch, "{}: {} × {} pixels, smaller than the box in samples.csv", printable(file),
           seen.image.cols, seen.image.rows);
    const fs::path mask = estancia::maskOf(folder_, view(i).name);
    if (!fs::is_regular_file(mask)) return seen;
    seen.mask = readLabelImage(mask);
    if (seen.mask.size() != seen.image.size())
      fail(ErrorCode::mismatch, "{}: {} × {} pixels, but its image has {} × {}", printable(mask),
           seen.mask.cols, seen.mask.rows, seen.image.cols, seen.image.rows);
    return seen;
  }

 private:
  fs::path folder_;
  std::vector<cv::Rect> boxes_;
};

/// Also with a malformed list, so that opening reports it.
bool isSampleViews(const fs::path& folder) {
  return fs::exists(folder / "samples.csv") ||
         (fs::is_directory(estancia::imageOf(folder, "x").parent_path()) &&
          fs::is_directory(estancia::cloudOf(folder, "x").parent_path()));
}

}  // namespace

const ViewFormat sampleViews{"samples",
                             "written by `estancia objects collect`: samples.csv, images/, clouds/",
                             isSampleViews, openViewsAs<SampleViews>};

}  // namespace io
}  // namespace estancia
