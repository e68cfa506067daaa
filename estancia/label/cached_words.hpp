// Cached descriptor: the bytes that a label cache keeps for an image.
#pragma once

#include <string>
#include <string_view>

#include "estancia/label/labeler.hpp"

namespace estancia {

/// The values as they are; of a labeler that discovers words, the words that are not 0 with their names,
/// since their numbers differ from run to run.
std::string packWords(DescriptorView descriptor, const Labeler& labeler);

/// Whether `bytes` are what packWords() makes for this labeler. Safe to call beside the labeler's work.
bool holdsWords(std::string_view bytes, const Labeler& labeler);

/// Back again; `bytes` must be sound.
LexicalDescriptor unpackWords(std::string_view bytes, Labeler& labeler);

}  // namespace estancia
