// TUM RGB-D: `rgb.txt` lists `time file`, `groundtruth.txt` the camera's trajectory in its own, denser times.
#include <fmt/format.h>

#include <cmath>

#include "estancia/core/error.hpp"
#include "estancia/io/files.hpp"
#include "estancia/io/formats.hpp"
#include "estancia/io/side_files.hpp"

namespace estancia::io {
namespace fs = std::filesystem;

bool isTumRgbd(const fs::path& path) {
  return fs::is_regular_file(path / "rgb.txt");
}

Opened openTumRgbd(const fs::path& path, const SequenceOptions& options) {
  const fs::path list = path / "rgb.txt";
  auto sequence = std::make_unique<ImageFiles>(nameOf(path));
  const auto lines = readLines(list);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto words = wordsOf(lines[i]);
    if (words.empty() || words[0].starts_with('#')) continue;
    const auto time = toNumber(words[0]);
    if (!time || !std::isfinite(*time) || words.size() < 2)
      throw Error(fmt::format("{}:{}: a line is `time file`", printable(list.string()), i + 1));
    const fs::path file = fs::path(std::string(words[1].begin(), words.back().end()))
                              .lexically_normal();  // names may hold blanks
    if (file.is_absolute() || *file.begin() == "..")
      throw Error(fmt::format("{}:{}: {} leads out of the data set's folder", printable(list.string()), i + 1,
                              printable(file.string())));
    Frame frame;
    frame.name = printable(file.string());
    frame.timestamp = time;
    sequence->add(std::move(frame), path / file);
  }
  if (sequence->size() == 0) throw Error(fmt::format("{}: lists no images", printable(list.string())));
  const fs::path truth = path / "groundtruth.txt";
  if (options.poses.empty() && fs::exists(truth))
    attachPoses(*sequence, readTrajectory(truth), truth, options.maxPoseGap);
  return sequence;
}

}  // namespace estancia::io
