#include "base/timer.hpp"

#include "base/log.hpp"

namespace fbi {
namespace {

const std::chrono::steady_clock::time_point process_start = std::chrono::steady_clock::now();

TimerNode*& current() {
  static TimerNode* node = &timer_root();
  return node;
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void print(const TimerNode& node, int depth, double total, std::string& text) {
  text += log::format("  %*s%-*s %10.3f s %6.1f %% %10ld\n", 2 * depth, "", 36 - 2 * depth, node.name.c_str(),
                      node.seconds, 100.0 * node.seconds / total, node.calls);
  double inside = 0.0;
  for (const auto& child : node.children) {
    print(*child, depth + 1, total, text);
    inside += child->seconds;
  }
  if (!node.children.empty() && node.seconds - inside > 0.005 * total)
    text += log::format("  %*s%-*s %10.3f s %6.1f %%\n", 2 * depth + 2, "", 34 - 2 * depth, "other",
                        node.seconds - inside, 100.0 * (node.seconds - inside) / total);
}

}  // namespace

TimerNode& timer_root() {
  static TimerNode root{"total", 0.0, 1, nullptr, {}};
  return root;
}

Timed::Timed(const char* name) : node_(nullptr), start_(std::chrono::steady_clock::now()) {
  TimerNode*& here = current();
  for (auto& child : here->children)
    if (child->name == name) node_ = child.get();
  if (node_ == nullptr) {
    here->children.push_back(std::make_unique<TimerNode>(TimerNode{name, 0.0, 0, here, {}}));
    node_ = here->children.back().get();
  }
  here = node_;
}

Timed::~Timed() {
  node_->seconds += seconds_since(start_);
  ++node_->calls;
  current() = node_->parent;
}

std::string timer_report() {
  TimerNode& root = timer_root();
  root.seconds = seconds_since(process_start);
  std::string text;
  print(root, 0, root.seconds, text);
  return text;
}

}  // namespace fbi
