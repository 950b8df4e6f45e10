C     Drives the subroutine without ABAQUS: stubs of the utility
C     routines, and a program that hands it nodal pressures.
C
C     Compiled as one file, so that an argument list that does not fit
C     is an error. No warnings are expected; the argument list of
C     UMESHMOTION is ABAQUS's, so that not all of it is used:
C
C       gfortran -Wall -Wextra -Wno-unused-dummy-argument harness.f
C       ./a.out < pressures.txt
C
C     Input: the number of nodes, of increments and of dimensions; the
C     node numbers; then for each increment DTIME [s] and the pressure
C     of each node [MPa]. Output, a line for each increment: PNEWDT and
C     the wear of each node [mm] in it.
      INCLUDE '../umeshmotion.f'
C
      SUBROUTINE GETNODETOELEMCONN(NODE,NELEMS,JELEMLIST,JELEMTYPE,
     *     JRCD,JGVBLOCK)
      INCLUDE 'ABA_PARAM.INC'
      DIMENSION JELEMLIST(*),JELEMTYPE(*),JGVBLOCK(*)
      NELEMS = 1
      JELEMLIST(1) = NODE
      JELEMTYPE(1) = 1
      JRCD = 0
      RETURN
      END
C
      SUBROUTINE GETVRMAVGATNODE(NODE,${jtyp_argument}VAR,ARRAY,JRCD,
     *     JELEMLIST,NELEMS,JMATYP,JGVBLOCK)
      INCLUDE 'ABA_PARAM.INC'
      PARAMETER (MAXNOD = 1000000)
      CHARACTER*(*) VAR
      DIMENSION ARRAY(15),JELEMLIST(*),JMATYP(*),JGVBLOCK(*)
      COMMON /STUBS/ PRESS(MAXNOD)
      JRCD = 1
      IF (VAR.EQ.'CSTRESS'.AND.PRESS(NODE).GT.0.0D0) THEN
        ARRAY(1) = PRESS(NODE)
        JRCD = 0
      END IF
      RETURN
      END
C
      SUBROUTINE GETOUTDIR(OUTDIR,LENDIR)
      CHARACTER*(*) OUTDIR
      OUTDIR = '.'
      LENDIR = 1
      RETURN
      END
C
      SUBROUTINE XIT
      STOP 1
      END
C
      PROGRAM DRIVE
      INCLUDE 'ABA_PARAM.INC'
      PARAMETER (MAXNOD = 1000000)
      COMMON /STUBS/ PRESS(MAXNOD)
      COMMON /DRIVEN/ WEAR(MAXNOD),LABEL(MAXNOD)
      DIMENSION ULOCAL(3),ALOCAL(3,3),TIME(2),JMATYP(1),JGVBLOCK(1)
C
      OPEN(UNIT=7,FILE='messages.txt',STATUS='REPLACE')
      ALOCAL = 0.0D0
      TIME = 0.0D0
      JMATYP = 0
      JGVBLOCK = 0
      READ(*,*) NNODES,NINCS,NDIM
      READ(*,*) (LABEL(I),I=1,NNODES)
      DO 10 I = 1,NDIM
        ALOCAL(I,I) = 1.0D0
   10 CONTINUE
      DO 30 KINC = 1,NINCS
        READ(*,*) DTIME,(PRESS(LABEL(I)),I=1,NNODES)
        TIME = TIME + DTIME
        PNEWDT = 1.0D30
        DO 20 I = 1,NNODES
          ULOCAL = 0.0D0
          CALL UMESHMOTION(1.0D0,ULOCAL,LABEL(I),NDIM,5,ALOCAL,NDIM,
     *        TIME,DTIME,PNEWDT,1,KINC,1,JMATYP,JGVBLOCK,0)
          WEAR(I) = (0.0D0-ULOCAL(NDIM))*DTIME
   20   CONTINUE
        WRITE(*,'(1000001ES26.16E3)') PNEWDT,(WEAR(I),I=1,NNODES)
   30 CONTINUE
      END
