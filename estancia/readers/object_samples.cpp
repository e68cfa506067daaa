// SPDX-License-Identifier: Apache-2.0
#include "estancia/readers/object_samples.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <string_view>
#include <unordered_map>

#include "estancia/core/fail.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/files/csv.hpp"
#include "estancia/files/files.hpp"

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
  const auto flag = [](bool set) { return std::string(set ? "1" : "0"); };
  return {sample.view.name,
          sample.view.instance,
          sample.view.category,
          sample.view.split,
          sample.view.frame,
          std::to_string(sample.box.x),
          std::to_string(sample.box.y),
          std::to_string(sample.box.width),
          std::to_string(sample.box.height),
          flag(sample.view.flat),
          flag(sample.view.atBorder)};
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
  std::string start(kindLine.size(), '\0');
  if (!fs::is_regular_file(listOf(folder))) return false;
  std::ifstream stream(listOf(folder), std::ios::binary);
  return stream.read(start.data(), static_cast<std::streamsize>(start.size())) && start == kindLine;
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

}  // namespace estancia
