// The one exception family of Estancia.
#pragma once

#include <stdexcept>
#include <string>

namespace estancia {

/// Base of everything Estancia throws. The message is one line: what is wrong, where, and what to do.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A sound question that has no answer: nothing is called so, no way leads there.
class NoAnswerError : public Error {
 public:
  using Error::Error;
};

/// Thrown when the user interrupts long work (Ctrl-C); everything done so far has been kept.
class Interrupted : public Error {
 public:
  using Error::Error;
};

}  // namespace estancia
