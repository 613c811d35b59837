"""Compiler pipeline of this package's kernels: Numba's own, with attributes that only these functions get.

Numba documents custom pipelines (``pipeline_class`` of ``jit``). No setting of Numba or LLVM changes for other code in
the process.
"""

from functools import cache
from typing import Any, Final

import llvmlite.binding as llvm
from llvmlite import ir
from llvmlite.binding import Linkage
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import register_pass
from numba.core.lowering import Lower
from numba.core.registry import cpu_target
from numba.core.typed_passes import NativeLowering, NopythonRewrites

CALL_STACK_ALIGNMENT_BYTES: Final = 64
"""Alignment of each function's stack, bytes: a cache line, and the widest vector."""

PYTHON_CALL_ERROR_FUNCTION_NAME: Final = "overturning_no_entry_from_python"
"""Name of the code that runs if Python calls an inner function."""

PYTHON_CALL_ERROR_MESSAGE: Final = (
    "this function is called by compiled code only; call its `.py_func`, or compile a caller"
)


class CallStackAligningLlvmTranslator(Lower):
    """Translator of a function to LLVM; it aligns the stack of the function to `CALL_STACK_ALIGNMENT_BYTES` bytes."""

    def setup_function(self, fndesc: Any) -> None:
        """Declare in LLVM the function that `fndesc` describes, and set the alignment of its stack."""
        super().setup_function(fndesc)
        # Spilled vectors lie on the stack. At LLVM's 16 bytes they can straddle two cache lines, which is slow.
        self.function.attributes.alignstack = CALL_STACK_ALIGNMENT_BYTES
        self.function.attributes.add("nounwind")  # llvmlite writes no alignment alone


class InternalFunctionLlvmTranslator(CallStackAligningLlvmTranslator):
    """Translator to LLVM of functions that only compiled code calls."""

    def create_cpython_wrapper(self, release_gil: bool = False) -> None:
        """Omit the entry point for calls from Python: all these functions share one (see `InternalFunctionLibrary`)."""


class KernelCodeWithoutUnusedArguments(JITCodeLibrary):
    """Machine code of a kernel and of the functions that it calls, without arguments that they do not use.

    Numba passes an array as seven numbers, of which most loops use only the address. Passing all of them takes up to a
    tenth of the time of a step of a scene.
    """

    def _optimize_final_module(self) -> None:
        super()._optimize_final_module()
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == Linkage.linkonce_odr:
                function.linkage = "private"  # only this kernel calls the function, so that its arguments may change
        passes = llvm.create_new_module_pass_manager()
        passes.add_ipsccp_pass()
        passes.add_dead_arg_elimination_pass()
        passes.add_global_opt_pass()
        passes.run(self._final_module, self._codegen._pass_builder())


class _CodeGeneratorWithoutPythonObjects:
    """Substitute for Numba's code generator, for functions that only compiled code calls.

    These functions use no Python objects.
    """

    def set_env(self, env_name: str, env: Any) -> None:
        """Ignore the Python objects that Numba would store for a function: compiled kernels use none."""


class InternalFunctionLibrary(JITCodeLibrary):
    """LLVM code of a function that only compiled code calls: it is linked into its callers.

    Machine code is generated for the calling kernel only. For inlined functions LLVM's optimisation is left to the
    caller, too. Machine code and optimisation of each such function would take a quarter of the compilation time.

    Attributes
    ----------
    is_inlined : bool
        Whether the function is part of each caller (``forceinline``).
    """

    is_inlined: bool = False

    @property
    def codegen(self) -> "_CodeGeneratorWithoutPythonObjects":
        """Code generator that Numba calls after it has translated a function; it has only the method `set_env`."""
        return _CodeGeneratorWithoutPythonObjects()

    def _optimize_final_module(self) -> None:
        if not self.is_inlined:
            super()._optimize_final_module()

    def _finalize_final_module(self) -> None:
        """Mark the library as finalised without machine code: only the code of its callers contains the functions."""
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:  # noqa: ARG002
        """Return the address of the code that runs if Python calls the function `name`: it raises a `TypeError`."""
        self._ensure_finalized()
        return int(
            _build_library_that_python_cannot_call(self._codegen).get_pointer_to_function(
                PYTHON_CALL_ERROR_FUNCTION_NAME
            )
        )


@cache
def _build_library_that_python_cannot_call(codegen: Any) -> Any:
    """Return a library with a function that raises an error if Python calls it."""
    module, pointer = ir.Module(PYTHON_CALL_ERROR_FUNCTION_NAME), ir.IntType(8).as_pointer()
    builder = ir.IRBuilder(
        ir.Function(
            module, ir.FunctionType(pointer, [pointer] * 3), PYTHON_CALL_ERROR_FUNCTION_NAME
        ).append_basic_block("start")
    )
    cpu_target.target_context.get_python_api(builder).err_set_string("PyExc_TypeError", PYTHON_CALL_ERROR_MESSAGE)
    builder.ret(ir.Constant(pointer, None))
    library = codegen.create_library(PYTHON_CALL_ERROR_FUNCTION_NAME)
    library.add_ir_module(module)
    return library


@register_pass(mutates_CFG=True, analysis_only=False)
class KernelLoweringPass(NativeLowering):
    """Compiler pass that translates a kernel (a function that Python calls) to LLVM."""

    _name = "kernel_lowering"

    def run_pass(self, state: Any) -> bool:
        """Translate a kernel to LLVM code in which functions have no unused arguments."""
        state.library = KernelCodeWithoutUnusedArguments(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        return bool(super().run_pass(state))

    @property
    def lowering_class(self) -> Any:
        """Class that translates functions to LLVM in this pass."""
        return CallStackAligningLlvmTranslator


@register_pass(mutates_CFG=True, analysis_only=False)
class InternalFunctionLoweringPass(NativeLowering):
    """Compiler pass that translates a function to LLVM if only compiled code calls the function."""

    _name = "inner_lowering"

    def run_pass(self, state: Any) -> bool:
        """Translate a function to LLVM code that is compiled to machine code only inside the functions that call it."""
        state.library = InternalFunctionLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.is_inlined = bool(state.flags.forceinline)
        return bool(super().run_pass(state))

    @property
    def lowering_class(self) -> Any:
        """Class that translates functions to LLVM in this pass."""
        return InternalFunctionLlvmTranslator


def _build_compiler_pipeline(compiler_state: Any, lowering_pass: type) -> Any:
    """Return Numba's compiler passes, with `lowering_pass` instead of Numba's translation to LLVM.

    Numba's pass that rewrites array expressions is left out.
    """
    passes = DefaultPassBuilder.define_nopython_pipeline(compiler_state)
    # No kernel has array expressions; searching for them takes a tenth of the time.
    passes.passes = [
        (lowering_pass, text) if one is NativeLowering else (one, text)
        for one, text in passes.passes
        if one is not NopythonRewrites
    ]
    passes.finalize()
    return passes


class PythonCallableKernelCompiler(CompilerBase):
    """Compiler of kernel functions that Python calls."""

    def define_pipelines(self) -> list[Any]:
        """Return the compiler passes for kernels: Numba's own, but `KernelLoweringPass` translates to LLVM."""
        return [_build_compiler_pipeline(self.state, KernelLoweringPass)]


class InternalFunctionCompiler(CompilerBase):
    """Compiler of kernel functions that only compiled code calls."""

    def define_pipelines(self) -> list[Any]:
        """Return the compiler passes: Numba's own, but `InternalFunctionLoweringPass` translates to LLVM."""
        return [_build_compiler_pipeline(self.state, InternalFunctionLoweringPass)]


class NoAliasFunctionCompiler(InternalFunctionCompiler):
    """Compiler of kernel functions that only compiled code calls, with array arguments that never overlap."""

    def define_pipelines(self) -> list[Any]:
        """Return the passes of `InternalFunctionCompiler`; array arguments are marked ``noalias`` (never overlap)."""
        self.state.flags.noalias = True
        return super().define_pipelines()
