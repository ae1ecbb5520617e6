// The workloads in fuzzylite's own C++ engine: set two inputs, process, read the output. Built by table.py where
// fuzzylite's headers and library are found. Arguments: a file in fuzzylite's language and a file of points, raw doubles.

#include <fl/Headers.h>

#include <chrono>
#include <cstdio>
#include <fstream>
#include <vector>

int main(int count, char** arguments) {
    if (count != 3) return 2;
    fl::Engine* engine = fl::FllImporter().fromFile(arguments[1]);
    std::ifstream file(arguments[2], std::ios::binary);
    std::vector<double> points;
    for (double x; file.read(reinterpret_cast<char*>(&x), sizeof x);) points.push_back(x);
    fl::InputVariable *a = engine->getInputVariable(0), *b = engine->getInputVariable(1);
    fl::OutputVariable* out = engine->getOutputVariable(0);
    double best = 1e9;
    for (int round = 0; round < 7; round++) {
        auto begin = std::chrono::steady_clock::now();
        for (std::size_t k = 0; k + 1 < points.size(); k += 2) {
            a->setValue(points[k]);
            b->setValue(points[k + 1]);
            engine->process();
        }
        double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        if (took < best) best = took;
    }
    std::printf("%.1f\n", best / (points.size() / 2) * 1e9);
}
