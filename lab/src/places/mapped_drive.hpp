// Mapped drive: a labeled drive becomes a map with the defaults, and another one is found in it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <vector>

#include "estancia/localization/localizer_map.hpp"
#include "estancia/mapper/mapper.hpp"
#include "estancia/query/accuracy.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "runner/scratch_file.hpp"

namespace estancia::experiments {

/// A map in a file of its own, as `estancia map` makes it; gone in the end. Throws Error when it cannot be
/// written.
class ScratchMap : public ScratchFile {
 public:
  ScratchMap(const DescriptorSequence& recording, std::filesystem::path path,
             const MapperOptions& options = {});
};

/// Removes the poses, for a robot that does not know where it is.
DescriptorSequence withoutPoses(DescriptorSequence recording);

/// Localizes the frames of `queries` in order, each answered `lookahead` frames later, with the other options
/// of the localizer as they are. An answer a frame.
std::vector<Localization> locate(const DescriptorSequence& queries, std::shared_ptr<const LocalizerMap> map,
                                 std::size_t lookahead);

/// How right answers to all frames of a drive are in `map` (measureLocalization()).
LocalizationAccuracy measureAnswers(const TopologicalMap& map, const std::vector<Frame>& frames,
                                    const std::vector<Localization>& answers,
                                    const AdmissibleImages& truth = {});

/// Both together.
LocalizationAccuracy findDrive(const DescriptorSequence& queries, std::shared_ptr<const LocalizerMap> map,
                               std::size_t lookahead, const AdmissibleImages& truth = {});

}  // namespace estancia::experiments
