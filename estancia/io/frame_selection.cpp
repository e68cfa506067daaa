// SPDX-License-Identifier: Apache-2.0
#include "estancia/io/formats.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <utility>

#include "estancia/core/fail.hpp"

namespace estancia::io {
namespace {

class Selection final : public Sequence {
 public:
  Selection(Opened whole, std::vector<std::size_t> kept, std::string name)
      : whole_(std::move(whole)), kept_(std::move(kept)), name_(std::move(name)) {
    warnings_ = whole_->warnings();
    intrinsics_ = whole_->intrinsics();
    poseSource_ = whole_->poseSource();
  }
  std::string name() const override { return name_; }
  std::size_t size() const override { return kept_.size(); }
  const Frame& frame(std::size_t i) const override { return whole_->frame(kept_[i]); }
  cv::Mat image(std::size_t i) const override { return whole_->image(kept_.at(i)); }
  std::string fingerprint(std::size_t i) const override { return whole_->fingerprint(kept_.at(i)); }
  bool hasDepth() const override { return whole_->hasDepth(); }
  cv::Mat depth(std::size_t i) const override { return whole_->depth(kept_.at(i)); }
  double depthScale() const override { return whole_->depthScale(); }
  std::optional<double> depthTimestamp(std::size_t i) const override {
    return whole_->depthTimestamp(kept_.at(i));
  }

 private:
  Opened whole_;
  std::vector<std::size_t> kept_;
  std::string name_;
};

/// "hall, kitchen, office", at most 50 of them.
std::string listed(const std::set<std::string>& names) {
  constexpr std::size_t maxNames = 50;
  if (names.size() <= maxNames) return fmt::format("{}", fmt::join(names, ", "));
  const std::vector<std::string> first(names.begin(), std::next(names.begin(), maxNames));
  return fmt::format("{} … ({} in total)", fmt::join(first, ", "), names.size());
}

/// The names that frames have, without "".
std::set<std::string> namesIn(const std::vector<std::string>& ofFrames) {
  std::set<std::string> names(ofFrames.begin(), ofFrames.end());
  names.erase("");
  return names;
}

void requireKnown(const std::string& sequence, const char* what, const std::string& name,
                  const std::set<std::string>& known) {
  if (known.empty())
    fail(ErrorCode::insufficientData,
         "{}: no frame has a known {}, as for \"{}\"; write rooms.csv (image,room,split)", sequence, what,
         name);
  if (!known.contains(name))
    fail(ErrorCode::unknownName, "{}: unknown {} \"{}\"; known: {}", sequence, what, name, listed(known));
}

}  // namespace

std::unique_ptr<Sequence> selectFrames(Opened sequence, const SequenceOptions& options) {
  if (options.split.empty() && options.only.empty()) return sequence;
  const std::string name = sequence->name();
  std::vector<std::string> splits = sequence->splits(), rooms;
  splits.resize(sequence->size());
  for (const Frame& frame : sequence->frames()) rooms.push_back(frame.room);
  const std::set<std::string> knownSplits = namesIn(splits), knownRooms = namesIn(rooms);
  if (!options.split.empty()) requireKnown(name, "split", options.split, knownSplits);
  for (const std::string& room : options.only) requireKnown(name, "room", room, knownRooms);
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < rooms.size(); ++i)
    if ((options.split.empty() || splits[i] == options.split) &&
        (options.only.empty() || std::ranges::find(options.only, rooms[i]) != options.only.end()))
      kept.push_back(i);
  if (kept.empty())
    fail(ErrorCode::insufficientData, "{}: no frame of the split \"{}\" is in {}", name, options.split,
         fmt::join(options.only, ", "));
  std::string shown = name;
  if (!options.split.empty()) shown += fmt::format(" ({})", options.split);
  return std::make_unique<Selection>(std::move(sequence), std::move(kept), std::move(shown));
}

}  // namespace estancia::io
