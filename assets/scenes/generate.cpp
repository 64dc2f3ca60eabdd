// Writes the included scenes as glTF files: generate_scenes FOLDER
#include "assets/scenes/gltf_writer.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>

int main(int argument_count, char **arguments) {
    if (argument_count != 2) {
        std::cerr << "generate_scenes: name the folder to write to, as in\n"
                     "  generate_scenes assets/scenes\n";
        return EXIT_FAILURE;
    }
    const std::filesystem::path folder = arguments[1];
    for (const springdrive::scenes::SceneDescription &scene : springdrive::scenes::all_scenes()) {
        const std::filesystem::path file = folder / (scene.name + ".gltf");
        std::ofstream stream(file, std::ios::binary);
        const std::string text = springdrive::scenes::to_gltf(scene);
        stream.write(text.data(), static_cast<std::streamsize>(text.size()));
        stream.close();
        if (!stream) {
            std::cerr << "generate_scenes: cannot write " << file.string()
                      << "; check that the folder exists and its permissions\n";
            return EXIT_FAILURE;
        }
        std::cout << file.string() << ": " << text.size() << " bytes\n";
    }
    return EXIT_SUCCESS;
}
