"""Compiler pipeline of this package's kernels: Numba's own, with attributes that only these functions get.

Numba documents custom pipelines (``pipeline_class`` of ``jit``). No setting of Numba or LLVM changes for other code in
the process.
"""

from typing import Any, Final

from llvmlite import ir
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import register_pass
from numba.core.lowering import Lower
from numba.core.typed_passes import NativeLowering, NopythonRewrites

STACK: Final = 64
"""Alignment of each function's stack, bytes: a cache line, and the widest vector."""

MESSAGE: Final = "this function is called by compiled code only; call its `.py_func`, or compile a caller"


class KernelLlvmTranslator(Lower):
    """Translator of a function to LLVM; it aligns the stack of the function to `STACK` bytes."""

    def setup_function(self, fndesc: Any) -> None:
        """Declare in LLVM the function that `fndesc` describes, and set the alignment of its stack."""
        super().setup_function(fndesc)
        # Spilled vectors lie on the stack. At LLVM's 16 bytes they can straddle two cache lines, which is slow.
        self.function.attributes.alignstack = STACK
        self.function.attributes.add("nounwind")  # llvmlite writes no alignment alone


class InnerFunctionLlvmTranslator(KernelLlvmTranslator):
    """Translator to LLVM of functions that only compiled code calls; a call from Python raises an error."""

    def create_cpython_wrapper(self, release_gil: bool = False) -> None:  # noqa: ARG002
        """Generate an entry point for Python that only raises a TypeError; a complete one takes long to compile."""
        module = self.context.create_module("no entry")
        pointer = ir.IntType(8).as_pointer()
        kind = ir.FunctionType(pointer, [pointer] * 3)
        builder = ir.IRBuilder(ir.Function(module, kind, self.fndesc.llvm_cpython_wrapper_name).append_basic_block())
        self.context.get_python_api(builder).err_set_string("PyExc_TypeError", MESSAGE)
        builder.ret(ir.Constant(pointer, None))
        self.library.add_ir_module(module)


@register_pass(mutates_CFG=True, analysis_only=False)
class KernelLoweringPass(NativeLowering):
    """Compiler pass that translates a function to LLVM if Python calls the function (a kernel)."""

    _name = "kernel_lowering"

    @property
    def lowering_class(self) -> Any:
        """Class that translates functions to LLVM in this pass."""
        return KernelLlvmTranslator


@register_pass(mutates_CFG=True, analysis_only=False)
class InnerFunctionLoweringPass(NativeLowering):
    """Compiler pass that translates a function to LLVM if only compiled code calls the function."""

    _name = "inner_lowering"

    @property
    def lowering_class(self) -> Any:
        """Class that translates functions to LLVM in this pass."""
        return InnerFunctionLlvmTranslator


def _build_compiler_pipeline(compiler_state: Any, lowering_pass: type) -> Any:
    """Return Numba's compiler passes, with `lowering_pass` in place of Numba's own and without array expressions."""
    passes = DefaultPassBuilder.define_nopython_pipeline(compiler_state)
    # No kernel has array expressions; searching for them takes a tenth of the time.
    passes.passes = [
        (lowering_pass, text) if one is NativeLowering else (one, text)
        for one, text in passes.passes
        if one is not NopythonRewrites
    ]
    passes.finalize()
    return passes


class KernelCompiler(CompilerBase):
    """Compiler of kernel functions that Python calls."""

    def define_pipelines(self) -> list[Any]:
        """Return Numba's pipeline of compiler passes, with `KernelLoweringPass` as its lowering pass."""
        return [_build_compiler_pipeline(self.state, KernelLoweringPass)]


class InnerFunctionCompiler(CompilerBase):
    """Compiler of kernel functions that only compiled code calls."""

    def define_pipelines(self) -> list[Any]:
        """Return Numba's pipeline of compiler passes, with `InnerFunctionLoweringPass` as its lowering pass."""
        return [_build_compiler_pipeline(self.state, InnerFunctionLoweringPass)]


class NoAliasFunctionCompiler(InnerFunctionCompiler):
    """Compiler of kernel functions that only compiled code calls, with array arguments that never overlap."""

    def define_pipelines(self) -> list[Any]:
        """Return the pipeline of `InnerFunctionCompiler`; array arguments are marked ``noalias`` (never overlap)."""
        self.state.flags.noalias = True
        return super().define_pipelines()
