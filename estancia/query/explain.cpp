// SPDX-License-Identifier: Apache-2.0
#include "estancia/query/explain.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "estancia/core/fail.hpp"
#include "estancia/files/files.hpp"
#include "estancia/map_file/places.hpp"
#include "estancia/query/drives.hpp"

namespace estancia {
namespace {

using Sentences = std::vector<std::string>;

[[noreturn]] void failNoFrame(const TopologicalMap& map, const std::string& asked) {
  if (map.frames.empty())
    throw Error(ErrorCode::insufficientData, "the map has no frames yet; map some images first");
  fail(ErrorCode::unknownName,
       "there is no frame \"{}\"; the map has frames {} to {}{}, named \"{}\" to \"{}\"",
       io::printable(asked), map.frames.front().number, map.frames.back().number,
       map.isThinned() ? " (its size is bounded: some are left out)" : "",
       io::printable(map.frames.front().name), io::printable(map.frames.back().name));
}

/// Drives often name their images alike.
[[noreturn]] void failSeveral(const TopologicalMap& map, const std::vector<std::size_t>& frames) {
  constexpr std::size_t most = 5;
  std::vector<std::string> numbers;
  for (const std::size_t frame : frames)
    if (numbers.size() < most)
      numbers.push_back(map.drives.empty() ? std::to_string(map.frames[frame].number)
                                           : fmt::format("{} ({})", map.frames[frame].number,
                                                         describeDrive(map, map.driveOf(frame))));
  fail(ErrorCode::unknownName, "{} frames are called \"{}\": {}{}; give the number of one", frames.size(),
       io::printable(map.frames[frames.front()].name), fmt::join(numbers, ", "),
       frames.size() > most ? ", …" : "");
}

template <class... Values>
void add(Sentences& sentences, fmt::format_string<Values...> text, Values&&... values) {
  sentences.push_back(fmt::format(text, std::forward<Values>(values)...));
}

void explainJoin(const Decision& d, Sentences& sentences) {
  if (d.other == d.current)
    return add(
        sentences,
        "Its distance to the current node {}, {:.4g}, is not below tau_join {:.4g}, but an earlier image "
        "of that node is {:.4g} away, below {:.4g}: it stayed there.",
        d.current, d.toCurrent, d.tauJoin, d.toOther, d.tauRevisit);
  add(sentences,
      "Its distance to the current node {}, {:.4g}, is below tau_join {:.4g}: it stayed there, and no other "
      "node was compared.",
      d.current, d.toCurrent, d.tauJoin);
  add(sentences, "With a tau_join of {:.4g} or less it would have left node {}.", d.toCurrent, d.current);
}

/// A frame that left its node, for another one or for a new one.
void explainMove(const Decision& d, Sentences& sentences) {
  if (d.current < 0)
    return add(sentences,
               "It was the first image of a drive. Node {} is {:.4g} away, below {:.4g}: it began there.",
               d.other, d.toOther, d.tauRevisit);
  if (d.kind == DecisionKind::revisit && d.toCurrent < d.tauJoin)
    return add(
        sentences,
        "An earlier image of node {} is {:.4g} away, below {:.4g}: it moved there, though its distance "
        "to the current node {}, {:.4g}, is below tau_join {:.4g}.",
        d.other, d.toOther, d.tauRevisit, d.current, d.toCurrent, d.tauJoin);
  add(sentences,
      "Its distance to the current node {}, {:.4g}, is not below tau_join {:.4g}: it left that node.",
      d.current, d.toCurrent, d.tauJoin);
  const bool nearer = d.toOther < d.toCurrent, similar = d.toOther < d.tauRevisit;
  const std::string other = fmt::format("The nearest other node, {}, is {:.4g} away, {} tau_revisit {:.4g}",
                                        d.other, d.toOther, similar ? "below" : "not below", d.tauRevisit);
  std::string otherwise =
      fmt::format("With a tau_join above {:.4g} it would have stayed in node {}", d.toCurrent, d.current);
  if (d.kind == DecisionKind::revisit) {
    add(sentences, "{}{}: it moved there.", other, nearer ? " and nearer than the current one" : "");
    otherwise +=
        fmt::format("; with a tau_revisit of {:.4g} or less it would have made a new node", d.toOther);
  } else if (d.other < 0) {
    add(sentences,
        "It was compared with no other node (there was none yet, or the drive may have been in another "
        "building): it made a new one, {}.",
        d.node);
  } else if (similar) {
    add(sentences, "{} but not nearer than the current one: it made a new node, {}.", other, d.node);
  } else {
    add(sentences, "{}: it made a new node, {}.", other, d.node);
    if (nearer)
      otherwise +=
          fmt::format("; with a tau_revisit above {:.4g} it would have moved to node {}", d.toOther, d.other);
  }
  add(sentences, "{}.", otherwise);
}

/// Follows the node of a decision through the merges that came after it.
void explainMerges(const TopologicalMap& map, const Decision& d, Sentences& sentences) {
  int node = d.node;
  for (const Merge& merge : map.merges) {
    if (merge.frame < d.frame || (merge.absorbed != node && merge.kept != node)) continue;
    if (std::isinf(merge.threshold)) {
      add(sentences,
          "After frame {} node {}, which held few frames, became a part of its neighbor, node {}: there was "
          "no memory for another place (--memory).",
          map.frames.at(merge.frame).number, merge.absorbed, merge.kept);
      node = merge.kept;
      continue;
    }
    if (merge.absorbed == node) {
      add(sentences,
          "After frame {} node {} turned out to be the same place as node {} (distance {:.4g}, below "
          "{:.4g}): the frame belongs to node {} since.",
          map.frames.at(merge.frame).number, merge.absorbed, merge.kept, merge.distance, merge.threshold,
          merge.kept);
      node = merge.kept;
    } else {
      add(sentences,
          "After frame {} its node {} took in node {}, which turned out to be the same place (distance "
          "{:.4g}, below {:.4g}).",
          map.frames.at(merge.frame).number, merge.kept, merge.absorbed, merge.distance, merge.threshold);
    }
  }
}

/// The predicted rooms of the frame and of the place that it is in now.
void explainRooms(const TopologicalMap& map, std::size_t frame, Sentences& sentences) {
  if (!map.predictions) return;
  const auto own = rankedRooms(*map.predictions, frame);
  const std::size_t place = indexOf(map, map.frames[frame].node);
  if (own.empty() || place == map.nodes.size()) return;
  add(sentences, "{} {} for this image, and {} for its place, node {}.",
      map.predictions->areByName ? "By its words alone, without a room classifier, the room is"
                                 : "The room classifier predicts",
      describeRooms(own), describeRooms(placesOf(map)[place].predicted), map.frames[frame].node);
}

}  // namespace

std::size_t getFrame(const TopologicalMap& map, const std::string& nameOrNumber) {
  // A sequence writes bytes that are not UTF-8 as \xFF; the shell gives them as they are.
  const std::string written = io::printable(nameOrNumber);
  std::vector<std::size_t> named;
  for (std::size_t i = 0; i < map.frames.size(); ++i)
    if (map.frames[i].name == nameOrNumber || map.frames[i].name == written) named.push_back(i);
  if (named.size() == 1) return named.front();
  if (named.size() > 1) failSeveral(map, named);
  std::size_t number = 0;
  const char* end = nameOrNumber.data() + nameOrNumber.size();
  const auto [rest, problem] = std::from_chars(nameOrNumber.data(), end, number);
  if (problem == std::errc() && rest == end)
    if (const auto frame = map.findFrame(number)) return *frame;
  failNoFrame(map, nameOrNumber);
}

std::vector<std::string> explain(const Decision& d, const std::string& name) {
  Sentences sentences;
  switch (d.kind) {
    case DecisionKind::start:
      add(sentences, "{} made node {}.", name, d.node);
      if (d.other < 0)
        add(sentences, "It was the first image: there was nothing to compare it with.");
      else
        add(sentences,
            "It was the first image of a drive. The nearest node, {}, is {:.4g} away, not below {:.4g}: the "
            "drive began in a new place.",
            d.other, d.toOther, d.tauRevisit);
      break;
    case DecisionKind::join:
      add(sentences, "{} stayed in node {}.", name, d.node);
      explainJoin(d, sentences);
      break;
    case DecisionKind::revisit:
      add(sentences, "{} returned to node {}.", name, d.node);
      explainMove(d, sentences);
      break;
    case DecisionKind::createNode:
      add(sentences, "{} made node {}, a new place.", name, d.node);
      explainMove(d, sentences);
      break;
    case DecisionKind::localize:
      add(sentences, "{} {} node {}.", name, d.current == d.other ? "stayed in" : "was localized in", d.node);
      add(sentences,
          "By all images of its drive so far the robot was there, and its words do not contradict: the "
          "nearest image or mean of that node is {:.4g} away, below {:.4g}.",
          d.toOther, d.tauRevisit);
      break;
  }
  return sentences;
}

std::vector<std::string> explain(const TopologicalMap& map, std::size_t frame) {
  if (frame >= map.frames.size()) failNoFrame(map, std::to_string(frame));
  const auto found = std::ranges::find(map.decisions, frame, &Decision::frame);
  if (found == map.decisions.end())
    fail(ErrorCode::insufficientData, "frame {} has no decision yet; continue the mapping",
         map.frames[frame].number);
  Sentences sentences = explain(
      *found, fmt::format("Frame {} ({})", map.frames[frame].number, io::printable(map.frames[frame].name)));
  explainMerges(map, *found, sentences);
  explainRooms(map, frame, sentences);
  return sentences;
}

}  // namespace estancia
