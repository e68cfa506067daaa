// Word files: word graphs and associations as bytes, so that WordNet is read and walked only once. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/words/word_associations.hpp"
#include "estancia/words/word_graph.hpp"

namespace estancia {

/// `source` identifies what the graph was built from.
std::string packWordGraph(const WordGraph& graph, std::string_view source);

/// Throws Error (malformedFile, truncatedFile, corruptFile, unsupportedFile) unless packWordGraph() of this
/// version wrote `bytes` from the same `source`. `name` stands in the message.
WordGraph unpackWordGraph(std::string_view bytes, std::string_view source, const std::string& name);

/// `source` identifies the words and labels.
std::string packAssociationsFile(const std::vector<WordAssociation>& associations, std::string_view source);

/// Throws Error (malformedFile, truncatedFile, corruptFile, unsupportedFile) unless packAssociationsFile() of
/// this version wrote `bytes` from the same `source`, for `labels` labels. `name` stands in the message.
std::vector<WordAssociation> unpackAssociationsFile(std::string_view bytes, std::string_view source,
                                                    std::size_t labels, const std::string& name);

struct InstalledWords {
  /// Nothing where there is no WordNet, or it cannot be read.
  std::optional<WordGraph> graph;
  /// Advice what to install, or the fault of the installed files; "" if there is a graph.
  std::string hint;
  /// Why reading it will take as long the next time; "" when nothing is wrong.
  std::string problem = {};
};

/// The word graph of findWordNet(), read from the file words-N.graph beside the label cache when that is of
/// the same WordNet, else from WordNet's texts (more than a second); then that file is written, if it can be.
InstalledWords loadInstalledWords();

}  // namespace estancia
