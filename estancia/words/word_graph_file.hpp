// Word graph file: a word graph as bytes, so that WordNet's texts are read only once.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "estancia/words/word_graph.hpp"

namespace estancia {

/// `source` identifies what the graph was built from.
std::string packWordGraph(const WordGraph& graph, std::string_view source);

/// Throws Error (malformedFile, truncatedFile, corruptFile, unsupportedFile) unless packWordGraph() of this
/// version wrote `bytes` from the same `source`. `name` stands in the message.
WordGraph unpackWordGraph(std::string_view bytes, std::string_view source, const std::string& name);

}  // namespace estancia
