// SPDX-License-Identifier: Apache-2.0
#include "estancia/sequences/listed_sequence.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <set>

#include "estancia/core/printable.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/words/name_search.hpp"

namespace estancia::io {
namespace {

class Selection final : public Sequence {
 public:
  /// `told`: warnings in addition to the whole sequence's.
  Selection(Opened whole, std::vector<std::size_t> kept, std::string name,
            const std::vector<std::string>& told)
      : whole_(std::move(whole)), kept_(std::move(kept)), name_(std::move(name)) {
    warnings_ = whole_->warnings();
    warnings_.insert(warnings_.end(), told.begin(), told.end());
    intrinsics_ = whole_->intrinsics();
    poseSource_ = whole_->poseSource();
  }
  std::string name() const override { return name_; }
  std::size_t size() const override { return kept_.size(); }
  const Frame& frame(std::size_t i) const override { return whole_->frame(kept_[i]); }
  cv::Mat image(std::size_t i) const override { return whole_->image(kept_.at(i)); }
  cv::Mat reducedImage(std::size_t i, int side) const override {
    return whole_->reducedImage(kept_.at(i), side);
  }
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

void requireAny(const std::string& sequence, const char* what, const std::string& name,
                const std::set<std::string>& known) {
  if (known.empty())
    fail(ErrorCode::insufficientData,
         "{}: no frame has a known {}, as for \"{}\"; write rooms.csv (image,room,split)", sequence, what,
         name);
}

void requireSplit(const std::string& sequence, const std::string& name, const std::set<std::string>& known) {
  requireAny(sequence, "split", name, known);
  if (!known.contains(name))
    fail(ErrorCode::unknownName, "{}: unknown split \"{}\"; known: {}", sequence, name, listed(known));
}

/// The rooms that a person means; `told` receives a sentence for each that is named otherwise.
std::set<std::string> roomsMeant(const std::string& sequence, const std::vector<std::string>& words,
                                 const std::set<std::string>& known, std::vector<std::string>& told) {
  const std::vector<std::string> rooms(known.begin(), known.end());
  std::set<std::string> meant;
  for (const std::string& word : words) {
    requireAny(sequence, "room", word, known);
    const auto match = findName(rooms, word, installedWordGraph);
    if (!match) {
      const std::vector<std::string> near = findNearNames(rooms, word, installedWordGraph);
      fail(ErrorCode::unknownName, "{}: unknown room \"{}\"{}; known: {}", sequence, printable(word),
           near.empty() ? "" : fmt::format(" (is it {}?)", fmt::join(near, ", ")), listed(known));
    }
    meant.insert(rooms[match->name]);
    if (!match->reason.empty())
      told.push_back(fmt::format("no room is called \"{}\": {} is taken, {}", printable(word),
                                 rooms[match->name], match->reason));
  }
  return meant;
}

}  // namespace

std::unique_ptr<Sequence> selectFrames(Opened sequence, const SequenceOptions& options) {
  if (options.split.empty() && options.only.empty()) return sequence;
  const std::string name = sequence->name();
  std::vector<std::string> splits = sequence->splits(), rooms;
  splits.resize(sequence->size());
  for (const Frame& frame : sequence->frames()) rooms.push_back(frame.room);
  const std::set<std::string> knownSplits = namesIn(splits), knownRooms = namesIn(rooms);
  if (!options.split.empty()) requireSplit(name, options.split, knownSplits);
  std::vector<std::string> told;
  const std::set<std::string> meant = roomsMeant(name, options.only, knownRooms, told);
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < rooms.size(); ++i)
    if ((options.split.empty() || splits[i] == options.split) && (meant.empty() || meant.contains(rooms[i])))
      kept.push_back(i);
  if (kept.empty())
    fail(ErrorCode::insufficientData, "{}: no frame of the split \"{}\" is in {}", name, options.split,
         fmt::join(meant, ", "));
  std::string shown = name;
  if (!options.split.empty()) shown += fmt::format(" ({})", options.split);
  return std::make_unique<Selection>(std::move(sequence), std::move(kept), std::move(shown), told);
}

}  // namespace estancia::io
