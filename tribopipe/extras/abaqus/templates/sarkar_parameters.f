C     Sarkar's law, friction mu(s) = AMU exp(-s/CMU) + BMU
C     CMU    running-in distance [mm]
C     FMAX   largest factor sqrt(1 + 3 mu^2) along the way
C     SSTART distance slid before this step [mm]: set it where the wear
C            goes on in another step, or after a correction of geometry
${slip_speed}      PARAMETER (AMU = $amplitude)
      PARAMETER (BMU = $steady_state)
      PARAMETER (CMU = $running_in_distance)
      PARAMETER (FMAX = $largest_factor)
      PARAMETER (SSTART = 0.0D0)
