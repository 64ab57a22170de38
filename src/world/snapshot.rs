//! Snapshots of a world: the columns that a step may change, the resources of a step, and the history of the stepper.

use crate::Stepper;
use crate::components::{ColumnVisitor, visit_columns};
use crate::environment::Environment;
use crate::schedule::{BalanceReport, ForceCommand, Phase, StepLoad, StepReport};
use base::error::{Error, Result};
use base::saved_state::{StateReader, StateWriter};
use bevy_ecs::component::{Component, Mutable};
use bevy_ecs::world::World;
use serde::Serialize;
use serde::de::DeserializeOwned;

impl Environment {
    /// Writes the state, from which a grasp continues bit for bit, in this process or another. The length does not
    /// depend on the number of steps taken.
    pub fn save_state(&self, stepper: &dyn Stepper, history: &mut StateWriter) {
        let world = self.world();
        // The history keeps errors until it is finished.
        let _ = visit_columns(&mut Writer { world, history });
        history.write(&world.get_resource::<Phase>());
        history.write(&world.get_resource::<ForceCommand>());
        history.write(&world.get_resource::<StepLoad>());
        history.write(&world.get_resource::<StepReport>());
        history.write(&world.get_resource::<BalanceReport>());
        stepper.save_state(world, history);
    }

    /// Reads what [`Environment::save_state`] wrote, into an environment just created with the same model, stepper
    /// and pose.
    ///
    /// # Errors
    /// Fails if the history does not match; the environment must then be restarted.
    pub fn restore_state(&mut self, stepper: &dyn Stepper, history: &mut StateReader) -> Result<()> {
        let world = self.world_mut();
        visit_columns(&mut Reader { world, history })?;
        read_resource::<Phase>(world, history)?;
        read_resource::<ForceCommand>(world, history)?;
        read_resource::<StepLoad>(world, history)?;
        read_resource::<StepReport>(world, history)?;
        read_resource::<BalanceReport>(world, history)?;
        stepper.restore_state(world, history)
    }
}

fn read_resource<R: bevy_ecs::resource::Resource + DeserializeOwned>(
    world: &mut World,
    history: &mut StateReader,
) -> Result<()> {
    match history.read::<Option<R>>()? {
        Some(resource) => world.insert_resource(resource),
        None => drop(world.remove_resource::<R>()),
    }
    Ok(())
}

/// Writes columns.
struct Writer<'a> {
    world: &'a World,
    history: &'a mut StateWriter,
}

impl ColumnVisitor for Writer<'_> {
    fn visit<C>(&mut self) -> Result<()>
    where
        C: Component<Mutability = Mutable> + Copy + Serialize + DeserializeOwned,
    {
        let query = self.world.try_query::<&C>();
        let values: Vec<C> = query.map_or_else(Vec::new, |mut query| query.iter(self.world).copied().collect());
        self.history.write(&values);
        Ok(())
    }
}

/// Reads columns.
struct Reader<'a, 'b> {
    world: &'a mut World,
    history: &'a mut StateReader<'b>,
}

impl ColumnVisitor for Reader<'_, '_> {
    fn visit<C>(&mut self) -> Result<()>
    where
        C: Component<Mutability = Mutable> + Copy + Serialize + DeserializeOwned,
    {
        let values: Vec<C> = self.history.read()?;
        let mut query = self.world.query::<&mut C>();
        if query.iter(self.world).count() != values.len() {
            return Err(Error::Start(
                "the number of nodes, edges or fingers of the saved state differs from that of the scene".into(),
            ));
        }
        query.iter_mut(self.world).zip(values).for_each(|(mut own, value)| *own = value);
        Ok(())
    }
}
