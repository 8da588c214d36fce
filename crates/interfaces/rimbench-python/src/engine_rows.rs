//! The interface model of the constraint rows of an engine, from the engine's own arrays and factors.

use numpy::{Element, IxDyn, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use std::ops::Range;

type Array<'py, T> = PyReadonlyArray<'py, T, IxDyn>;

/// An array of the engine's model or data.
fn array<'py, T: Element>(of: &Bound<'py, PyAny>, name: &Bound<'py, PyString>) -> PyResult<Array<'py, T>> {
    let wrong = || PyValueError::new_err(format!("the engine's {name} is no array of the kind that it was"));
    of.getattr(name)?.extract().map_err(|_| wrong())
}

/// Its numbers from the first one on, at least so many.
fn first<'a, T: Element>(array: &'a Array<'_, T>, count: usize) -> PyResult<&'a [T]> {
    let short = || PyValueError::new_err(format!("an array of the engine has fewer than {count} numbers"));
    array.as_slice()?.get(..count).ok_or_else(short)
}

fn add_multiple(to: &mut [f64], factor: f64, of: &[f64]) {
    to.iter_mut().zip(of).for_each(|(to, of)| *to += factor * of);
}

/// Constraint rows `u` and the interface `i` of a model of MuJoCo. It has room for those that there were at most.
///
/// ```text
/// [Hᵀ; aᵀ] = [J; τᵀ] [M⁻¹ J_uᵀ  M_h⁻¹ J_iᵀ]        J = [J_u; J_i]
/// ```
/// Rows of equalities always push, as springs, and are eliminated.
/// # Source
/// `docs/guide/mujoco.md`
#[pyclass(name = "EngineRows", module = "rimbench._native")]
#[derive(Default)]
pub struct EngineRows {
    /// Where each row of the factor `Lᵀ D L` lies, the diagonal last, and the columns.
    spans: Vec<Range<usize>>,
    columns: Vec<usize>,
    /// Kinds of rows: of equalities, of edges of pyramids.
    kinds: [i32; 2],
    /// `[J; τᵀ]`, row-major, and `M⁻¹ Jᵀ`.
    rows: Vec<f64>,
    answers: Vec<f64>,
    /// `[Hᵀ; aᵀ]`, row-major, and the rows of it that are no equalities.
    found: Vec<f64>,
    kept: Vec<usize>,
}

#[pymethods]
impl EngineRows {
    #[new]
    fn new(model: &Bound<'_, PyAny>, kinds: [i32; 2]) -> PyResult<Self> {
        let whole = |name| -> PyResult<Vec<usize>> {
            let numbers = array::<i32>(model, &PyString::new(model.py(), name))?;
            Ok(numbers.as_slice()?.iter().map(|number| *number as usize).collect())
        };
        let (counts, starts) = (whole("M_rownnz")?, whole("M_rowadr")?);
        let spans = starts.iter().zip(&counts).map(|(start, count)| *start..start + count).collect();
        Ok(EngineRows { spans, columns: whole("M_colind")?, kinds, ..EngineRows::default() })
    }

    /// Returns the rows of the model as they are in `data`, whose velocities of the interface have the Jacobian
    /// `interface` and answer over the integrator's step by the factors of M_h if it is `damped`.
    fn of<'py>(
        &mut self,
        data: &Bound<'py, PyAny>,
        interface: PyReadonlyArray2<'py, f64>,
        speeds: PyReadonlyArray1<'py, f64>,
        is_sparse: bool,
        damped: bool,
    ) -> PyResult<Bound<'py, PyDict>> {
        let py = data.py();
        let numbers = |name| array::<f64>(data, name);
        let kinds = array::<i32>(data, intern!(py, "efc_type"))?;
        let kinds = kinds.as_slice()?;
        let (n, nv, m) = (kinds.len(), self.spans.len(), speeds.as_slice()?.len());
        let width = n + m;
        self.take_rows(data, n, is_sparse)?;
        self.rows.extend_from_slice(interface.as_slice()?);
        self.rows.extend_from_slice(first(&numbers(intern!(py, "qfrc_smooth"))?, nv)?);

        let EngineRows { spans, columns, rows, answers, found, kept, .. } = self;
        answers.clear();
        answers.resize(nv * width, 0.0);
        for (column, row) in rows.chunks_exact(nv).take(width).enumerate() {
            row.iter().zip(answers[column..].iter_mut().step_by(width)).for_each(|(entry, to)| *to = *entry);
        }
        let (own, other) = if damped { (0..n, n..width) } else { (0..width, 0..0) };
        let (factor, inverse) = (numbers(intern!(py, "qLD"))?, numbers(intern!(py, "qLDiagInv"))?);
        solve(spans, columns, [factor.as_slice()?, first(&inverse, nv)?], (answers, width), own)?;
        if damped {
            let (factor, inverse) = (numbers(intern!(py, "qH"))?, numbers(intern!(py, "qHDiagInv"))?);
            solve(spans, columns, [factor.as_slice()?, first(&inverse, nv)?], (answers, width), other)?;
        }
        found.clear();
        found.resize((width + 1) * width, 0.0);
        for (row, found) in rows.chunks_exact(nv).zip(found.chunks_exact_mut(width)) {
            for (entry, answers) in row.iter().zip(answers.chunks_exact(width)).filter(|(entry, _)| **entry != 0.0) {
                add_multiple(found, *entry, answers);
            }
        }

        let weights = numbers(intern!(py, "efc_D"))?;
        let weights = first(&weights, n)?;
        kept.clear();
        kept.extend((0..n).filter(|row| kinds[*row] != self.kinds[0]));
        if kept.len() < n {
            let wanted = numbers(intern!(py, "efc_aref"))?;
            let wanted = first(&wanted, n)?;
            for row in (0..n).filter(|row| kinds[*row] == self.kinds[0]) {
                found[width * width + row] -= wanted[row];
                let (before, rest) = found.split_at_mut(row * width);
                let (own, after) = rest.split_at_mut(width);
                let pivot = own[row] + 1.0 / weights[row];
                for other in before.chunks_exact_mut(width).chain(after.chunks_exact_mut(width)) {
                    add_multiple(other, -other[row] / pivot, own);
                }
            }
        }
        self.told(data, kinds, weights, speeds.as_slice()?)
    }
}

/// Replaces some columns of `x`, `width` to a row, by the answers to them of `Lᵀ D L`: the `factor` is L beside its
/// diagonal, and 1/D.
fn solve(
    spans: &[Range<usize>],
    columns: &[usize],
    [factor, inverse]: [&[f64]; 2],
    (x, width): (&mut [f64], usize),
    some: Range<usize>,
) -> PyResult<()> {
    if factor.len() < columns.len() {
        return Err(PyValueError::new_err("the engine's factor has fewer entries than its pattern"));
    }
    let entries = |span: &Range<usize>| columns[span.start..span.end - 1].iter().zip(&factor[span.start..span.end - 1]);
    for (dof, span) in spans.iter().enumerate().rev() {
        let (before, own) = x.split_at_mut(dof * width);
        for (column, entry) in entries(span) {
            add_multiple(&mut before[column * width..][some.clone()], -entry, &own[some.clone()]);
        }
    }
    for (row, inverse) in x.chunks_exact_mut(width).zip(inverse) {
        row[some.clone()].iter_mut().for_each(|number| *number *= inverse);
    }
    for (dof, span) in spans.iter().enumerate() {
        let (before, own) = x.split_at_mut(dof * width);
        for (column, entry) in entries(span) {
            add_multiple(&mut own[some.clone()], -entry, &before[column * width..][some.clone()]);
        }
    }
    Ok(())
}

impl EngineRows {
    /// Takes the Jacobian of `n` constraint rows, as the engine keeps it.
    fn take_rows(&mut self, data: &Bound<'_, PyAny>, n: usize, is_sparse: bool) -> PyResult<()> {
        let (py, nv, rows) = (data.py(), self.spans.len(), &mut self.rows);
        let entries = array::<f64>(data, intern!(py, "efc_J"))?;
        rows.clear();
        if !is_sparse {
            rows.extend_from_slice(first(&entries, n * nv)?);
            return Ok(());
        }
        rows.resize(n * nv, 0.0);
        let whole = |name| array::<i32>(data, name);
        let [counts, starts, columns] =
            [intern!(py, "efc_J_rownnz"), intern!(py, "efc_J_rowadr"), intern!(py, "efc_J_colind")].map(whole);
        let (counts, starts, columns) = (counts?, starts?, columns?);
        let (entries, columns) = (entries.as_slice()?, columns.as_slice()?);
        for ((row, count), start) in rows.chunks_exact_mut(nv).zip(first(&counts, n)?).zip(first(&starts, n)?) {
            let span = *start as usize..(start + count) as usize;
            let found = columns.get(span.clone()).zip(entries.get(span));
            let (columns, entries) = found.ok_or_else(|| PyValueError::new_err("a row of efc_J ends beyond it"))?;
            columns.iter().zip(entries).for_each(|(column, entry)| row[*column as usize] = *entry);
        }
        Ok(())
    }

    /// The model of the rows that are kept, and of the interface with its velocities.
    fn told<'py>(
        &self,
        data: &Bound<'py, PyAny>,
        kinds: &[i32],
        weights: &[f64],
        of_interface: &[f64],
    ) -> PyResult<Bound<'py, PyDict>> {
        let (py, n, m, kept) = (data.py(), kinds.len(), of_interface.len(), &self.kept);
        let (width, all) = (n + m, kept.len() + m);
        let stacked = || kept.iter().copied().chain(n..n + m);
        let h = PyArray2::zeros(py, [all, all], false);
        {
            let mut h = h.try_readwrite()?;
            for (row, to) in stacked().zip(h.as_slice_mut()?.chunks_exact_mut(all)) {
                to.iter_mut().zip(stacked()).for_each(|(to, column)| *to = self.found[column * width + row]);
            }
        }
        let [rates, positions, margins, speeds] = ["efc_KBIP", "efc_pos", "efc_margin", "efc_vel"]
            .map(|name| array::<f64>(data, &PyString::intern(py, name)));
        let (rates, positions, margins, speeds) = (rates?, positions?, margins?, speeds?);
        let (rates, positions) = (first(&rates, 4 * n)?, first(&positions, n)?);
        let (margins, speeds) = (first(&margins, n)?, first(&speeds, n)?);
        let of_rows = |part: &dyn Fn(usize) -> f64| PyArray1::from_iter(py, kept.iter().map(|row| part(*row)));
        let dict = PyDict::new(py);
        dict.set_item(intern!(py, "H"), h)?;
        dict.set_item(intern!(py, "a"), PyArray1::from_iter(py, stacked().map(|row| self.found[width * width + row])))?;
        let w = kept.iter().map(|row| speeds[*row]).chain(of_interface.iter().copied());
        dict.set_item(intern!(py, "w"), PyArray1::from_iter(py, w))?;
        dict.set_item(intern!(py, "gap"), of_rows(&|row| positions[row] - margins[row]))?;
        dict.set_item(intern!(py, "compliance"), of_rows(&|row| 1.0 / weights[row]))?;
        dict.set_item(intern!(py, "damping"), of_rows(&|row| rates[4 * row + 1]))?;
        dict.set_item(intern!(py, "stiffness"), of_rows(&|row| rates[4 * row] * rates[4 * row + 2]))?;
        // The other edge of a pyramid in the same direction, which is its neighbour, and of all else the row itself.
        let opposite = PyArray1::from_iter(py, (0..kept.len()).map(|row| row as f64));
        {
            let (mut numbers, mut one) = (opposite.try_readwrite()?, None);
            let numbers = numbers.as_slice_mut()?;
            for at in (0..kept.len()).filter(|at| kinds[kept[*at]] == self.kinds[1]) {
                match one.take() {
                    Some(one) => numbers.swap(one, at),
                    None => one = Some(at),
                }
            }
        }
        dict.set_item(intern!(py, "opposite"), opposite)?;
        Ok(dict)
    }
}
