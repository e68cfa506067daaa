// Error: the one exception family of Estancia, with a stable code beside the sentence.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

namespace estancia {

/// Kind of failure. Programs and tests compare codes; sentences may change between versions.
enum class ErrorCode {
  /// An option is out of its range, or two options exclude each other.
  invalidOption,
  /// No method, preset, model, label or key has that name; the sentence lists the known ones.
  unknownName,
  /// A function cannot work on this data: empty, not finite, or of the wrong type or size.
  invalidInput,
  /// Two inputs do not belong together: other vocabularies, models, sizes or frames.
  mismatch,
  /// Too few images, classes, points or answers for what was asked.
  insufficientData,
  /// More than a limit or the memory allows.
  tooLarge,
  /// There is no file or folder of that name.
  fileNotFound,
  /// A file is in the way and may not be replaced.
  fileExists,
  /// A file or folder exists but cannot be read.
  fileUnreadable,
  /// A file or folder cannot be written.
  fileUnwritable,
  /// The content of a file breaks its format.
  malformedFile,
  /// A file ends too early.
  truncatedFile,
  /// A file is damaged: its digest or its own bookkeeping disagrees with its content.
  corruptFile,
  /// A file is of a kind, version or variant that this program does not read.
  unsupportedFile,
  /// A path would leave its folder, or content reaches outside of what was declared.
  unsafePath,
  /// Another process holds what is needed.
  busy,
  /// A connection failed or timed out.
  network,
  /// A server answered with a failure.
  serverFailure,
  /// A labeler (program, service, network) failed or gave answers that are none.
  labelerFailure,
  /// An optional library or tool is not installed.
  missingDependency,
  /// A sound question has no answer.
  noAnswer,
  /// The user asked to stop.
  interrupted,
  /// A call that the state of the object does not allow.
  invalidState,
};

/// The stable name of a code: "file-not-found".
std::string_view nameOf(ErrorCode code);
/// The code of a stable name; nothing for other texts.
std::optional<ErrorCode> findErrorCode(std::string_view name);

/// Base of everything Estancia throws. The message is one line: what is wrong, where, and what to do. It
/// often quotes files and names of others, so it is printable() (core), and of more than 2,000 bytes the
/// middle is left out.
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, std::string_view sentence);
  ErrorCode code() const { return code_; }

 private:
  ErrorCode code_;
};

/// A sound question that has no answer: nothing has that name, no route leads there.
class NoAnswerError : public Error {
 public:
  explicit NoAnswerError(const std::string& sentence) : Error(ErrorCode::noAnswer, sentence) {}
};

/// Thrown when the user interrupts long work (Ctrl-C); everything done so far has been kept.
class Interrupted : public Error {
 public:
  explicit Interrupted(const std::string& sentence) : Error(ErrorCode::interrupted, sentence) {}
};

}  // namespace estancia
