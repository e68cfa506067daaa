// SPDX-License-Identifier: Apache-2.0
#include "estancia/classify/model_file.hpp"
#include "estancia/objects/instance_accuracy.hpp"
#include "estancia/objects/object_model.hpp"
#include "fuzz/fuzz_target.hpp"

namespace estancia::fuzz {

/// The content: behind a right digest.
FUZZ_TARGET(objects, object_model) {
  const std::filesystem::path file = folder() / "input.objects";
  writeModelFile(file, objectModelKind, bytes);
  readObjectModel(file);
}

FUZZ_TARGET(objects, target_classes) {
  readTargetClasses(inputFile("targets.toml", bytes));
}

FUZZ_TARGET(objects, thing_classes) {
  readThingClasses(inputFile("things.toml", bytes));
}

}  // namespace estancia::fuzz
