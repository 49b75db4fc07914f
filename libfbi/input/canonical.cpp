#include "input/canonical.hpp"

#include <nlohmann/json.hpp>
#include <stdexcept>

namespace fbi::input {

std::string canonical_text(const std::string& text, const std::vector<std::string>& left_out) {
  nlohmann::json value = nlohmann::json::parse(text, nullptr, false, true);
  if (value.is_discarded()) throw std::invalid_argument("not JSON");
  for (const std::string& entry : left_out) {
    const nlohmann::json::json_pointer pointer(entry);
    if (value.contains(pointer)) value[pointer.parent_pointer()].erase(pointer.back());
  }
  return value.dump();
}

}  // namespace fbi::input
