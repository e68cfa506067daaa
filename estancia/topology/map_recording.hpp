// The words that a map was made of, for whoever works on words: nothing is labeled again.
#pragma once

#include <filesystem>

#include "estancia/io/descriptor_sequence.hpp"

namespace estancia {

/// The frames of a map file with their descriptors, as of one moment. Throws Error as MapStore::open() does.
DescriptorSequence readMapDescriptors(const std::filesystem::path& map);

}  // namespace estancia
