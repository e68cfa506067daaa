// SPDX-License-Identifier: Apache-2.0
#include "estancia/report/page_contents.hpp"

#include "estancia/report/image_grid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <unordered_map>

#include "estancia/core/frame.hpp"
#include "estancia/map_file/store.hpp"

namespace estancia {

PageImages imagesOf(const MapStore& map, const std::vector<Frame>& frames) {
  std::unordered_map<std::string, std::size_t> stored;
  const TopologicalMap content = map.load();
  for (const std::size_t frame : map.imageFrames())
    if (const auto index = content.findFrame(frame)) stored.emplace(content.frames[*index].name, frame);
  PageImages images;
  std::map<std::size_t, std::size_t> there;
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (const auto found = stored.find(frames[i].name); found != stored.end()) {
      images.frames.push_back(i);
      there[i] = found->second;
    }
  images.read = [&map, there = std::move(there)](std::size_t frame) { return map.image(there.at(frame)); };
  return images;
}

}  // namespace estancia

namespace estancia::report {
namespace {

/// At most `count` of the frames that have images, evenly spread.
std::vector<std::size_t> choose(const std::vector<std::size_t>& frames,
                                const std::vector<std::size_t>& imaged, std::size_t count) {
  std::vector<std::size_t> candidates, chosen;
  std::set_intersection(frames.begin(), frames.end(), imaged.begin(), imaged.end(),
                        std::back_inserter(candidates));
  count = std::min(count, candidates.size());
  for (std::size_t i = 0; i < count; ++i)
    chosen.push_back(candidates[(2 * i + 1) * candidates.size() / (2 * count)]);
  return chosen;
}

}  // namespace

LoadedImages loadImages(const std::vector<const std::vector<std::size_t>*>& places,
                        const PageImages& images) {
  LoadedImages loaded;
  if (!images.read) return loaded;
  std::vector<std::vector<std::size_t>> chosen;
  chosen.reserve(places.size());
  for (const auto* frames : places) chosen.push_back(choose(*frames, images.frames, images.each));
  std::size_t left = images.bytes;
  for (std::size_t round = 0; round < images.each; ++round)
    for (const auto& frames : chosen) {
      if (round >= frames.size()) continue;
      // the middle first, should there be room for one only
      const std::size_t frame = frames[(round + frames.size() / 2) % frames.size()];
      std::vector<unsigned char> bytes = left > 0 ? images.read(frame) : std::vector<unsigned char>{};
      if (left > 0 && bytes.empty()) continue;
      if (left == 0 || bytes.size() > left) {
        left = 0;
        ++loaded.withheld;
        continue;
      }
      left -= bytes.size();
      loaded.byFrame.emplace(frame, std::move(bytes));
    }
  return loaded;
}

Markup imageGrid(const LoadedImages& images, const std::vector<std::size_t>& frames, const std::string& what,
                 const std::function<std::string(std::size_t)>& nameOf) {
  std::vector<std::size_t> shown;
  for (const auto& [frame, bytes] : images.byFrame)
    if (std::binary_search(frames.begin(), frames.end(), frame)) shown.push_back(frame);
  Markup grid;
  if (shown.empty()) return grid;
  grid.open("div", {{"class", fmt::format("images p{}", std::min<std::size_t>(shown.size(), 4))}});
  for (const std::size_t frame : shown) {
    const std::string name = fmt::format("frame {}: {}", frame, shorten(nameOf(frame), 80));
    grid.leaf("img", {{"src", imageUri(images.byFrame.at(frame), "the image of " + name)},
                      {"alt", what + ", " + name},
                      {"title", name},
                      {"decoding", "async"}});
  }
  return grid.close();
}

}  // namespace estancia::report
