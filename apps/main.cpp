#include <cstdio>

#include "estancia/core/progress.hpp"

int main() {
  estancia::catchInterrupts();
  std::puts("estancia");
  return 0;
}
