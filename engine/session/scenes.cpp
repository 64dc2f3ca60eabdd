#include "engine/session/scenes.h"

#include <utility>

namespace springdrive::session {

Scenes::Scenes(const device::Workspace &workspace, std::unique_ptr<LoadedScene> first)
    : now_(std::move(first)), loader_(workspace) {}

void Scenes::request(const std::filesystem::path &file, const SceneLoader::Finish &finish) {
    loader_.request(file, finish);
}

const LoadedScene *Scenes::take_loaded() {
    std::unique_ptr<LoadedScene> loaded = loader_.take();
    if (!loaded) {
        return nullptr;
    }
    retired_.push_back(std::exchange(now_, std::move(loaded)));
    ++id_;
    return retired_.back().get();
}

void Scenes::note_in_use(std::uint32_t id) {
    if (id != id_) {
        return;
    }
    for (std::unique_ptr<LoadedScene> &scene : std::exchange(retired_, {})) {
        release_.let_go(std::move(scene));
    }
}

} // namespace springdrive::session
