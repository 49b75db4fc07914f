/// Floating-point traps switched off for a scope.
#pragma once

#include <cfenv>

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

namespace fbi::input {

/// While it lives, an overflow, a division by zero or an invalid operation yields inf or NaN instead of a signal; the
/// traps and flags of before come back at its end. Cheap (two register moves), so that it may surround each evaluation
/// of a formula.
class FloatTrapsOff {
 public:
#if defined(__SSE2__)
  FloatTrapsOff() : state_(_mm_getcsr()) { _mm_setcsr(state_ | _MM_MASK_MASK); }
  ~FloatTrapsOff() { _mm_setcsr(state_); }
#else
  FloatTrapsOff() { std::feholdexcept(&state_); }
  ~FloatTrapsOff() { std::fesetenv(&state_); }
#endif
  FloatTrapsOff(const FloatTrapsOff&) = delete;
  FloatTrapsOff& operator=(const FloatTrapsOff&) = delete;

 private:
#if defined(__SSE2__)
  unsigned state_;
#else
  std::fenv_t state_;
#endif
};

}  // namespace fbi::input
