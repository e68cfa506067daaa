// Descriptors by name: "gist", "inception-v3", "inception-v3+gist".
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "estancia/describe/descriptor.hpp"
#include "estancia/labelers/model.hpp"

namespace estancia {

struct NamedDescriptor {
  std::string name;
  std::unique_ptr<Descriptor> descriptor;
};

/// Loads the descriptors between the plus signs (an existing path is one name): descriptorTypes() or models.
/// Throws Error (unknownName, invalidOption) when a name is unknown, missing or given twice.
std::vector<NamedDescriptor> loadDescriptors(const std::string& names, const LabelerOptions& options = {});

/// Loads one combined descriptor for single views; describeSequence() is for sequences.
std::unique_ptr<Descriptor> loadDescriptor(const std::string& names, const LabelerOptions& options = {});

}  // namespace estancia
