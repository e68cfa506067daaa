// SPDX-License-Identifier: Apache-2.0
#include "estancia/files/camera_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/core/fail.hpp"
#include "estancia/files/files.hpp"

namespace estancia::io {
namespace fs = std::filesystem;
namespace {

/// The numbers of a text; `#` starts a comment. Throws Error at a word that is none.
std::vector<double> numbersOf(std::string text, const std::string& name) {
  std::vector<double> numbers;
  for (bool comment = false; char& c : text) {
    comment = c != '\n' && (comment || c == '#');
    if (comment || std::string_view(",;[]\r\n").find(c) != std::string_view::npos) c = ' ';
  }
  for (const auto word : wordsOf(text)) {
    const auto number = toNumber(word);
    if (!number)
      fail(ErrorCode::malformedFile, "{}: \"{}\" is no number; give fx fy cx cy, or the 3×3 camera matrix",
           name, printable(word));
    numbers.push_back(*number);
  }
  return numbers;
}

/// Position of the value of `key:`; npos when no line starts with it.
std::size_t placeOf(std::string_view text, std::string_view key, std::size_t from = 0) {
  for (auto at = text.find(key, from); at != std::string_view::npos; at = text.find(key, at + 1)) {
    const auto before = text.find_last_not_of(" \t", at == 0 ? std::string_view::npos : at - 1);
    const bool startsLine = at == 0 || before == std::string_view::npos || text[before] == '\n';
    const auto colon = text.find_first_not_of(" \t", at + key.size());
    if (startsLine && colon != std::string_view::npos && text[colon] == ':') return colon + 1;
  }
  return std::string_view::npos;
}

/// The text between the brackets after `from`.
std::optional<std::string> listAt(std::string_view text, std::size_t from) {
  const auto open = text.find('[', from), close = text.find(']', from);
  if (open == std::string_view::npos || close == std::string_view::npos || close < open) return std::nullopt;
  return std::string(text.substr(open + 1, close - open - 1));
}

int sizeOf(std::string_view text, std::initializer_list<std::string_view> keys) {
  for (const auto key : keys) {
    const auto at = placeOf(text, key);
    if (at == std::string_view::npos) continue;
    const auto words = wordsOf(text.substr(at, text.find_first_of("\r\n", at) - at));
    const auto number = words.empty() ? std::nullopt : toNumber(words[0]);
    if (number && *number >= 1 && *number <= 1 << 20) return static_cast<int>(*number);
  }
  return 0;
}

CameraIntrinsics cameraOf(const std::vector<double>& n, const std::string& name) {
  const auto refuse = [&name](const std::string& what) {
    fail(ErrorCode::malformedFile,
         "{}: {}; give fx fy cx cy in pixels, or the matrix fx 0 cx, 0 fy cy, 0 0 1", name, what);
  };
  if (n.size() != 4 && n.size() != 9 && n.size() != 16)
    refuse(fmt::format("{} numbers instead of 4, 9 or 16", n.size()));
  if (!std::ranges::all_of(n, [](double v) { return std::isfinite(v) && std::abs(v) < 1e6; }))
    refuse("a number is not finite or above 1e6");
  CameraIntrinsics camera;
  if (n.size() == 4) {
    camera = {0, 0, n[0], n[1], n[2], n[3]};
  } else {
    const std::size_t row = n.size() == 9 ? 3 : 4;
    camera = {0, 0, n[0], n[row + 1], n[2], n[row + 2]};
    constexpr double tolerance = 1e-6;
    if (std::abs(n[2 * row]) > tolerance || std::abs(n[2 * row + 1]) > tolerance ||
        std::abs(n[2 * row + 2] - 1) > tolerance)
      refuse("the third row of the camera matrix is not 0 0 1");
    if (std::abs(n[1]) > 1e-3 * n[0] || std::abs(n[row]) > tolerance)
      refuse("cameras with skewed pixels are not supported");
  }
  if (!(camera.fx > 0 && camera.fy > 0)) refuse("the focal lengths must be above 0");
  return camera;
}

}  // namespace

CameraIntrinsics readIntrinsics(const fs::path& file) {
  const std::string name = printable(file), text = readBytes(file, 1 << 16);  // a few lines
  for (const std::string_view key : {"camera_matrix", "Camera_Matrix", "K", "k"}) {
    const auto at = placeOf(text, key);
    if (at == std::string_view::npos) continue;
    const auto list = listAt(text, at);
    if (!list) fail(ErrorCode::malformedFile, "{}: {} has no list of numbers [ … ]", name, key);
    CameraIntrinsics camera = cameraOf(numbersOf(*list, name), name);
    camera.width = sizeOf(text, {"image_width", "Image_Width", "width"});
    camera.height = sizeOf(text, {"image_height", "Image_Height", "height"});
    if (camera.width == 0 || camera.height == 0) camera.width = camera.height = 0;
    return camera;
  }
  return cameraOf(numbersOf(text, name), name);
}

std::filesystem::path findIntrinsics(const std::filesystem::path& folder) {
  for (const char* name : {"camera-intrinsics.txt", "intrinsics.txt", "camera.yaml"}) {
    std::error_code none;
    if (std::filesystem::is_regular_file(folder / name, none)) return folder / name;
  }
  return {};
}

}  // namespace estancia::io
