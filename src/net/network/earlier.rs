//! Models of features of version 3: those that came later stand behind them, and count as nothing.

use super::card::{Card, Trained};
use crate::error::{Error, Result};
use crate::net::features::loads::PAD_LOAD;
use crate::net::features::normalise::Normaliser;
use crate::net::features::{NODE, PAD};
use safetensors::SafeTensors;
use safetensors::tensor::{Dtype, TensorView, serialize};
use std::borrow::Cow;

/// Version that can still be read.
pub const EARLIER: u32 = 3;
/// Weights with a row per feature, and the number of features today.
const WIDER: [(&str, usize); 4] = [
    ("start.node.weight", NODE.len()),
    ("start.pad", PAD.len()),
    ("node.pad_load", PAD_LOAD.len()),
    ("pad.load", PAD_LOAD.len()),
];

/// Returns the same model with weights of zero for the features that came later.
///
/// # Errors
/// Fails if the weights are not safetensors.
pub fn widened(Trained { card, weights }: Trained) -> Result<Trained> {
    let fail = |e: safetensors::SafeTensorError| Error::Solver(format!("the weights cannot be read: {e}"));
    let stored = SafeTensors::deserialize(&weights).map_err(fail)?;
    let mut more = 0;
    let grown: Vec<(String, Vec<usize>, Vec<u8>)> = stored
        .iter()
        .map(|(name, view)| {
            let (mut shape, mut data) = (view.shape().to_vec(), view.data().to_vec());
            if let (Some((_, rows)), [own, cols]) = (WIDER.iter().find(|(wider, _)| *wider == name), &mut shape[..]) {
                more += rows.saturating_sub(*own) * *cols;
                *own = *rows;
                data.resize(*rows * *cols * size_of::<f32>(), 0);
            }
            (name.to_string(), shape, data)
        })
        .collect();
    let views = grown.iter().map(|(name, shape, data)| Ok((name, TensorView::new(Dtype::F32, shape.clone(), data)?)));
    let views = views.collect::<std::result::Result<Vec<_>, _>>().map_err(fail)?;
    let weights = serialize(views, None).map_err(fail)?;
    let mut normalisers = card.normalisers.clone();
    let all: [(&mut Normaliser, usize); 3] = [
        (&mut normalisers.node, NODE.len()),
        (&mut normalisers.pad, PAD.len()),
        (&mut normalisers.pad_load, PAD_LOAD.len()),
    ];
    all.into_iter().for_each(|(normaliser, columns)| normaliser.widen(columns));
    let card = Card { parameters: card.parameters + more, normalisers, ..card };
    Ok(Trained { card, weights: Cow::Owned(weights) })
}
