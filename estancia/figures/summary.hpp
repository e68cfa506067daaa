// Node summary: what a page shows of each node, and when the robot was there (visits).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>

#include "estancia/figures/color.hpp"
#include "estancia/map_file/map.hpp"
#include "estancia/words/label_concepts.hpp"

namespace estancia::report {

/// A stay of the robot somewhere.
struct VisitSpan {
  std::size_t first = 0, last = 0;  ///< frame numbers, both included
};

/// Adds a frame later than all before: to the stay that it continues, else as a new one.
void addFrame(std::vector<VisitSpan>& visits, std::size_t frame);

/// The visits as a strip over a run of `frames`.
Markup visitStrip(const std::vector<VisitSpan>& visits, std::size_t frames);

/// "3 visits, frames 4 to 80"
std::string describeVisits(const std::vector<VisitSpan>& visits);

struct NodeSummary {
  const Node* node = nullptr;       ///< node of the summarized map
  std::string room;                 ///< the room most of its frames are in, "" when unknown
  std::string predictedRoom;        ///< what a classifier takes it for, "" when none was asked
  std::string predicted;            ///< `predicted` with other candidates: "kitchen 83 %, office 10 %"
  std::string title;                ///< familiarTitle() against the run
  double share = 0;                 ///< share of all frames, 0 … 1
  std::vector<std::size_t> frames;  ///< ascending
  std::vector<VisitSpan> visits;    ///< ascending, uninterrupted stays
};

/// Two nodes joined by at least one transition, whatever the direction.
struct Link {
  std::size_t a = 0, b = 0;  ///< positions in MapSummary::nodes, a < b
  std::uint64_t there = 0;   ///< transitions a → b
  std::uint64_t back = 0;    ///< transitions b → a
};

struct MapSummary {
  const TopologicalMap* map = nullptr;
  const LabelConcepts* concepts = nullptr;  ///< never nullptr after summarize()
  std::vector<NodeSummary> nodes;           ///< in order of id
  std::vector<Link> links;                  ///< ordered; transitions to nowhere or to oneself are left out
  std::map<std::string, ClassStyle> roomStyles;  ///< empty when no room is known
  std::vector<std::string> rooms;                ///< rooms of the nodes, in order of first appearance
  std::size_t roomsDriven = 0;                   ///< different rooms among the frames

  ClassStyle styleOf(const NodeSummary& node) const;
};

/// Both must outlive the summary; without concepts each label stands for itself.
MapSummary summarize(const TopologicalMap& map, const LabelConcepts* concepts = nullptr);

}  // namespace estancia::report
