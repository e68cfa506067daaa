// Descriptors by name: "gist", "inception-v3", "inception-v3+gist".
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "estancia/describe/descriptor.hpp"
#include "estancia/label/model.hpp"

namespace estancia {

struct NamedDescriptor {
  std::string name;
  std::unique_ptr<Descriptor> descriptor;
};

/// The names between plus signs (a path that exists is one name), each one of descriptorTypes() or a model.
/// Throws Error when a name is unknown (listing the known ones), missing or given twice.
std::vector<NamedDescriptor> loadDescriptors(const std::string& names, const LabelerOptions& options = {});

/// The same as one descriptor, for a robot that describes what it sees now; describeSequence() is for runs.
std::unique_ptr<Descriptor> loadDescriptor(const std::string& names, const LabelerOptions& options = {});

}  // namespace estancia
