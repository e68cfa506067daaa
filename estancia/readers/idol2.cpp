// KTH-IDOL2: ground truth in file names, t<time>_r<room>_x<x>_y<y>_a<theta>.<ext> (seconds, meters, radians).
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "estancia/readers/formats.hpp"

namespace estancia::io {
namespace fs = std::filesystem;
namespace {

/// Nothing when the name has another form. The numbers may be negative or in exponent form (-1.2e-05).
std::optional<Frame> frameOf(const fs::path& file) {
  const std::string stem = file.stem().string();
  std::vector<std::string_view> parts;
  for (std::string_view rest = stem;;) {
    const auto end = rest.find('_');
    parts.push_back(rest.substr(0, end));
    if (end == std::string_view::npos) break;
    rest.remove_prefix(end + 1);
  }
  constexpr std::string_view letters = "trxya";
  if (parts.size() != letters.size()) return std::nullopt;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (!parts[i].starts_with(letters[i]) || parts[i].size() < 2) return std::nullopt;
    parts[i].remove_prefix(1);
  }
  const auto time = toNumber(parts[0]), x = toNumber(parts[2]), y = toNumber(parts[3]),
             theta = toNumber(parts[4]);
  if (!time || !x || !y || !theta || !std::isfinite(*time)) return std::nullopt;
  Frame frame{printable(file.filename()), time, {}, printable(parts[1])};
  if (std::isfinite(*x) && std::isfinite(*y) && std::isfinite(*theta))
    frame.pose = Pose::planar(*x, *y, *theta);
  return frame;
}

}  // namespace

static bool isIdol2(const fs::path& path) {
  if (!fs::is_directory(path)) return false;
  return std::ranges::any_of(filesIn(path, imageSuffixes()),
                             [](const fs::path& f) { return frameOf(f).has_value(); });
}

static Opened openIdol2(const fs::path& path, const SequenceOptions&) {
  struct Named {
    Frame frame;
    fs::path file;
  };
  std::vector<Named> images;
  std::vector<fs::path> others;
  for (const auto& file : filesIn(path, imageSuffixes())) {
    if (auto frame = frameOf(file))
      images.push_back({std::move(*frame), file});
    else
      others.push_back(file);
  }
  if (images.empty())
    fail(ErrorCode::insufficientData,
         "{}: no images named as in KTH-IDOL2 (t<time>_r<room>_x<x>_y<y>_a<theta>.png)", printable(path));
  std::ranges::stable_sort(images, {}, [](const Named& n) { return *n.frame.timestamp; });
  auto sequence = std::make_unique<ImageFiles>(nameOf(path));
  for (auto& [frame, file] : images) sequence->add(std::move(frame), std::move(file));
  if (!others.empty())
    sequence->warn(fmt::format("{} images are left out for names that are not those of KTH-IDOL2 (first: {})",
                               others.size(), printable(others.front().filename())));
  return sequence;
}

const SequenceFormat idol2Format{"idol2", "KTH-IDOL2: t<time>_r<room>_x<x>_y<y>_a<theta>.png", isIdol2,
                                 openIdol2};

}  // namespace estancia::io
