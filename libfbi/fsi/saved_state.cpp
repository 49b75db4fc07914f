#include "fsi/saved_state.hpp"

namespace fbi::fsi {

SavedAcceleration::SavedAcceleration(Acceleration* acceleration) : acceleration_(acceleration) {
  if (acceleration_ == nullptr) return;
  history_ = acceleration_->history();
  for (const auto& [name, values] : acceleration_->state()) arrays_.push_back(*values);
}

void SavedAcceleration::restore() const {
  if (acceleration_ == nullptr) return;
  acceleration_->set_history(history_);  // how many arrays there are is part of it
  const auto state = acceleration_->state();
  for (std::size_t k = 0; k < state.size(); ++k) *state[k].second = arrays_[k];
}

std::vector<double*> SavedState::numbers() const {
  std::vector<double*> list;
  for (const auto& [name, value] : system_.scalars()) list.push_back(value);
  if (system_.has_fluid())
    for (const auto& [name, value] : system_.fluid().scalars()) list.push_back(value);
  return list;
}

SavedState::SavedState(System& system) : system_(system) {
  for (const auto& [name, values] : system_.fiber_state()) arrays_.push_back(*values);
  for (double* number : numbers()) numbers_.push_back(*number);
  lambda_ = system_.lambda_old();
  line_force_ = system_.saved_line_force();
  if (!system_.has_fluid()) return;
  for (const auto& [name, vector] : system_.fluid().state()) {
    vectors_.push_back(system_.fluid().create_vector());
    FBI_PETSC(VecCopy(vector, vectors_.back()));
  }
}

void SavedState::restore() const {
  const auto arrays = system_.fiber_state();
  for (std::size_t k = 0; k < arrays.size(); ++k) *arrays[k].second = arrays_[k];
  const std::vector<double*> now = numbers();
  for (std::size_t k = 0; k < now.size(); ++k) *now[k] = numbers_[k];
  system_.lambda_old() = lambda_;
  system_.saved_line_force() = line_force_;
  if (!system_.has_fluid()) return;
  const auto vectors = system_.fluid().state();
  for (std::size_t k = 0; k < vectors.size(); ++k) FBI_PETSC(VecCopy(vectors_[k], vectors[k].second));
  system_.fluid().state_restored();
}

}  // namespace fbi::fsi
