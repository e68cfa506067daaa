// Human labeler: images labeled by hand, in a CSV file.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "estancia/core/vocabulary.hpp"
#include "estancia/io/descriptor_sequence.hpp"
#include "estancia/label/labeler.hpp"
#include "estancia/label/model_spec.hpp"

namespace estancia {

/// Reads `image,label` or `image,label;label2;…` (the labels of an image share its probability), or
/// `image,label,confidence`, with or without such a header; an image may have several lines. The vocabulary
/// is `given`, or the labels in the file, sorted. What people leave unsaid is not impossible, and a hard zero
/// outweighs everything else in the distances of log-ratios; so a descriptor is
///     certainty · (labels of the person) + (1 − certainty) / L,
/// the label smoothing of Szegedy et al. 2016 (section 7) with ε = 1 − certainty, in [0, 1]. Throws Error
/// `FILE:LINE: …`, also on labels that are not in `given`.
DescriptorSequence readHumanLabels(const std::filesystem::path& file,
                                   const std::optional<Vocabulary>& given = {}, double certainty = 0.95);

/// Type "human": `file`, `labels`, `certainty`. Throws Error as readHumanLabels() does.
std::unique_ptr<Labeler> openHuman(const ModelSpec& spec);

}  // namespace estancia
