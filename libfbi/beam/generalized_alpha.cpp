#include "beam/generalized_alpha.hpp"

namespace fbi::beam {

GeneralizedAlpha::GeneralizedAlpha(double rho_inf) {
  alpha_m = (2 * rho_inf - 1) / (rho_inf + 1);
  alpha_f = rho_inf / (rho_inf + 1);
  beta = 0.25 * (1 - alpha_m + alpha_f) * (1 - alpha_m + alpha_f);
  gamma = 0.5 - alpha_m + alpha_f;
}

}  // namespace fbi::beam
