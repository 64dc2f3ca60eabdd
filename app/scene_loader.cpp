#include "app/scene_loader.h"

#include "engine/contact/preparation/mesh_remarks.h"
#include "engine/scene/gltf.h"
#include "engine/servo/record/file_hash.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <thread>
#include <utility>

namespace springdrive {

std::unique_ptr<LoadedScene> load_scene(const std::filesystem::path &file,
                                        const Workspace &workspace, LoadProgress &progress) {
    Scene scene = load_gltf(file, workspace, &progress);
    progress.begin(LoadProgress::Stage::preparing, false);
    HapticSurface surface(scene.surface, scene.shapes);
    std::ranges::move(remarks_on(surface.report(), scene.surface.materials),
                      std::back_inserter(scene.remarks));
    return std::make_unique<LoadedScene>(
        LoadedScene{std::move(scene), std::move(surface), sha256_of_file(file)});
}

void SceneLoader::request(const std::filesystem::path &file) {
    if (is_loading()) {
        next_file_ = file;
        return;
    }
    error_.clear();
    progress_ = std::make_shared<LoadProgress>();
    std::packaged_task<std::unique_ptr<LoadedScene>()> load(
        [file, workspace = workspace_, progress = progress_] {
            return load_scene(file, workspace, *progress);
        });
    loading_ = load.get_future();
    // Detached, so that whoever closes the window need not wait for a large file.
    std::thread(std::move(load)).detach();
}

std::unique_ptr<LoadedScene> SceneLoader::take() {
    if (!loading_.valid() ||
        loading_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
        return nullptr;
    }
    std::unique_ptr<LoadedScene> scene;
    try {
        scene = loading_.get();
    } catch (const std::exception &error) {
        error_ = error.what();
    }
    if (next_file_) {
        request(*std::exchange(next_file_, std::nullopt));
    }
    return scene;
}

} // namespace springdrive
