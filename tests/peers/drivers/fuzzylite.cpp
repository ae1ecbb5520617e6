// Evaluates FLL with fuzzylite's C++ engine. Argument: a folder. Reads every NAME.fll in it with its points NAME.points,
// one a line, and writes the outputs to NAME.out, or to NAME.err why there are none. The points of a file are a sequence:
// an engine keeps what it holds.

#include <fl/Headers.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

namespace fs = std::filesystem;

static void evaluate(const fs::path& path) {
    std::unique_ptr<fl::Engine> engine(fl::FllImporter().fromFile(path.string()));
    std::string status;
    if (not engine->isReady(&status)) throw fl::Exception(status);
    for (std::size_t b = 0; b < engine->numberOfRuleBlocks(); b++) {
        const fl::RuleBlock* block = engine->getRuleBlock(b);
        for (std::size_t r = 0; r < block->numberOfRules(); r++)
            if (not block->getRule(r)->isLoaded()) throw fl::Exception("a rule is not loaded");
    }
    std::ostringstream out;
    std::ifstream points(fs::path(path).replace_extension(".points"));
    for (std::string line; std::getline(points, line);) {
        const char* place = line.c_str();
        for (std::size_t i = 0; i < engine->numberOfInputVariables(); i++) {
            char* end;
            engine->getInputVariable(i)->setValue(std::strtod(place, &end));
            place = end;
        }
        engine->process();
        for (std::size_t i = 0; i < engine->numberOfOutputVariables(); i++) {
            char number[40];
            std::snprintf(number, sizeof number, "%.17g ", engine->getOutputVariable(i)->getValue());
            out << number;
        }
        out << "\n";
    }
    std::ofstream(fs::path(path).replace_extension(".out")) << out.str();
}

int main(int count, char** arguments) {
    if (count != 2) return 2;
    fl::fuzzylite::setLogging(false);
    for (const fs::directory_entry& entry : fs::directory_iterator(arguments[1])) {
        if (entry.path().extension() != ".fll") continue;
        try {
            evaluate(entry.path());
        } catch (const std::exception& error) {
            std::ofstream(fs::path(entry.path()).replace_extension(".err")) << error.what() << "\n";
        }
    }
}
