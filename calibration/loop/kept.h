#pragma once

#include <map>
#include <memory>
#include <typeindex>
#include <utility>

namespace caltwin {

/// What the procedures on one bench keep from one to the next, one object a type: the
/// engine's idea of a printer, what a person reads. Copies share the objects.
class Kept {
 public:
  /// Null where nothing of that type was put here.
  template <typename T>
  T* Find() const {
    const auto found = by_type_.find(std::type_index(typeid(T)));
    return found == by_type_.end() ? nullptr : static_cast<T*>(found->second.get());
  }
  /// In place of what there was of that type.
  template <typename T>
  T* Put(T object) {
    const auto held = std::make_shared<T>(std::move(object));
    by_type_[std::type_index(typeid(T))] = held;
    return held.get();
  }

 private:
  std::map<std::type_index, std::shared_ptr<void>> by_type_{};
};

}  // namespace caltwin
