"""The forces of ground and obstacles on the bodies of a vehicle."""

from collections.abc import Sequence

import numpy as np
from pydrake.common.value import Value
from pydrake.multibody.plant import ContactResults
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import BasicVector, Context

from workbench.systems.discrete_system import DiscreteSystem


class ContactForces(DiscreteSystem):
    """Adds up the contact forces on each of some bodies.

    Input port:
        contact_results: of the plant, whose contacts are points.
    Output port:
        contact_forces (3 k): total force on each body in W [N].

    Args:
        bodies: indices of the bodies in the plant (k).
    """

    def __init__(self, *, bodies: Sequence[BodyIndex]) -> None:
        super().__init__()
        self._places = {int(body): 3 * place for place, body in enumerate(bodies)}
        self._contacts = self.DeclareAbstractInputPort("contact_results", Value[ContactResults]())
        self.DeclareVectorOutputPort(
            "contact_forces",
            3 * len(self._places),
            self._calc_contact_forces,
            {self._contacts.ticket()},
        )

    def _calc_contact_forces(self, context: Context, output: BasicVector) -> None:
        contacts, total = self._contacts.Eval(context), np.zeros(3 * len(self._places))
        for number in range(contacts.num_point_pair_contacts()):
            contact = contacts.point_pair_contact_info(number)
            for body, sign in ((contact.bodyA_index(), -1.0), (contact.bodyB_index(), 1.0)):
                place = self._places.get(int(body))
                if place is not None:
                    total[place : place + 3] += sign * contact.contact_force()
        output.SetFromVector(total)
