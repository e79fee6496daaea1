// A plugin of oclgrind that counts what kernels do: lanes of floating-point operations and bytes of global memory, per
// kernel, as JSON in the file that RAYCUBE_FLOPS names. bench/flops.py compiles it against LLVM 14, oclgrind's own, and
// runs it; it is no part of the build.
//
// An instruction on a vector counts once for each lane, whether a mask makes use of it or not: that is what the machine
// computes.
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <string>

#include <oclgrind/common.h>
#include <oclgrind/Context.h>
#include <oclgrind/Kernel.h>
#include <oclgrind/KernelInvocation.h>
#include <oclgrind/Memory.h>
#include <oclgrind/Plugin.h>

#include <llvm/IR/Function.h>
#include <llvm/IR/Instructions.h>

namespace {

using Number = unsigned long long;

struct Counts {
  Number launches = 0;
  std::map<std::string, Number>
      lanes;  ///< of instructions by their names, of functions without a body of ours by theirs as mangled
  Number loaded_bytes = 0, stored_bytes = 0;
};

/// Instructions on floating-point numbers; the rest is addresses, integers and control.
const char* name_of(unsigned opcode) {
  switch (opcode) {
    case llvm::Instruction::FAdd:
      return "fadd";
    case llvm::Instruction::FSub:
      return "fsub";
    case llvm::Instruction::FMul:
      return "fmul";
    case llvm::Instruction::FDiv:
      return "fdiv";
    case llvm::Instruction::FRem:
      return "frem";
    case llvm::Instruction::FCmp:
      return "fcmp";
    default:
      return nullptr;
  }
}

class Flops : public oclgrind::Plugin {
 public:
  explicit Flops(const oclgrind::Context* context) : Plugin(context) {}

  void kernelBegin(const oclgrind::KernelInvocation* launch) override {
    now_ = &all_[launch->getKernel()->getName()];
    ++now_->launches;
  }
  /// After each launch, since a program may end before its plugins do.
  void kernelEnd(const oclgrind::KernelInvocation*) override {
    now_ = nullptr;
    write();
  }

  void instructionExecuted(const oclgrind::WorkItem*, const llvm::Instruction* instruction,
                           const oclgrind::TypedValue& result) override {
    // oclgrind 21.10 negates a bool by all bits of its byte, so that the opposite of true is 0xfe, which is true:
    // `~mask` then holds on every lane, and primary rays took triangles that they see for such as cross the sensor's
    // plane, which cost ten times the work for the same hits.
    if (instruction->getOpcode() == llvm::Instruction::Xor && instruction->getType()->getScalarType()->isIntegerTy(1))
      for (unsigned i = 0; i < result.num * result.size; ++i) result.data[i] &= 1;
    if (!now_) return;
    if (const char* name = name_of(instruction->getOpcode())) {
      now_->lanes[name] += result.num;
    } else if (instruction->getOpcode() == llvm::Instruction::Call) {
      const llvm::Function* called = llvm::cast<llvm::CallInst>(instruction)->getCalledFunction();
      if (called && called->isDeclaration() && called->getReturnType()->isFPOrFPVectorTy())
        now_->lanes[called->getName().str()] += result.num;
    }
  }

  void memoryLoad(const oclgrind::Memory* memory, const oclgrind::WorkItem*, size_t, size_t size) override {
    if (now_ && memory->getAddressSpace() == oclgrind::AddrSpaceGlobal) now_->loaded_bytes += size;
  }
  void memoryStore(const oclgrind::Memory* memory, const oclgrind::WorkItem*, size_t, size_t size,
                   const uint8_t*) override {
    if (now_ && memory->getAddressSpace() == oclgrind::AddrSpaceGlobal) now_->stored_bytes += size;
  }

  bool isThreadSafe() const override { return false; }

 private:
  void write() const {
    const char* path = std::getenv("RAYCUBE_FLOPS");
    std::FILE* file = path ? std::fopen(path, "w") : nullptr;
    if (!file) return;
    std::fprintf(file, "{");
    const char* next = "";
    for (const auto& [kernel, counts] : all_) {
      std::fprintf(file,
                   "%s\n  \"%s\": {\"launches\": %llu, \"loaded_bytes\": %llu, \"stored_bytes\": %llu, \"lanes\": {",
                   next, kernel.c_str(), counts.launches, counts.loaded_bytes, counts.stored_bytes);
      const char* comma = "";
      for (const auto& [name, lanes] : counts.lanes)
        std::fprintf(file, "%s\"%s\": %llu", comma, name.c_str(), lanes), comma = ", ";
      std::fprintf(file, "}}");
      next = ",";
    }
    std::fprintf(file, "\n}\n");
    std::fclose(file);
  }

  static inline std::map<std::string, Counts> all_;  ///< of all contexts
  Counts* now_ = nullptr;
};

/// One for each context that the program makes.
std::map<oclgrind::Context*, std::unique_ptr<Flops>> plugins;

}  // namespace

extern "C" {
void initializePlugins(oclgrind::Context* context) {
  plugins[context] = std::make_unique<Flops>(context);
  context->registerPlugin(plugins[context].get());
}
void releasePlugins(oclgrind::Context* context) {
  context->unregisterPlugin(plugins[context].get());
  plugins.erase(context);
}
}
