// Object commands: the subcommands of `estancia objects`.
#pragma once

#include <CLI/CLI.hpp>

#include "common.hpp"
#include "estancia/cloud/crop_object.hpp"

namespace estancia::apps {

/// Adds SEQ and how to read it with depth.
void addSequenceWithDepth(CLI::App& command, SequenceArguments& sequence);

/// Adds what labelers see around things.
void addPatchOptions(CLI::App& command, CropOptions& patches);

void addObjectsCollect(CLI::App& objects);
void addObjectsLabel(CLI::App& objects);
void addObjectsTrain(CLI::App& objects);
void addObjectsPredict(CLI::App& objects);

}  // namespace estancia::apps
